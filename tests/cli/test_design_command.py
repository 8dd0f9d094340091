"""`egad design`: what it writes, and what it says about a bad space or hand."""

import json
import re

import pytest
import trimesh
import yaml
from commands import egad

from egad import Gripper
from egad.bench.hands import HandComparison

QUICK = "{drops: 1, search_drops: 1, tries: 1, naive: 1, errors: {}, noise: none}"
SPACE = f"""
tips: {{length: [0.01, 0.02], thickness: 0.006, angle: [-2, 2]}}
evaluations: 2
generation: 2
trials: {QUICK}
judged: {QUICK}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, with meshes in millimetres, and spaces of tips."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "parts").mkdir()
    for name, sides in {"bar": (30, 50, 30), "cube": (30, 30, 30), "long": (25, 80, 30)}.items():
        trimesh.creation.box(sides).export(tmp_path / "parts" / f"{name}.stl")
    (tmp_path / "tips.yaml").write_text(SPACE)
    (tmp_path / "bad.yaml").write_text("tips: {length: [0.02, 0.01]}\n")
    (tmp_path / "mounts.yaml").write_text("tips: {mount: [glue, screw]}\n")
    (tmp_path / "steep.yaml").write_text("tips: {groove_angle: 80}\n")
    return tmp_path


def designed(*more):
    common = ("--out", "tips", "--objects", "parts", "--units", "mm", "--engine", "mujoco")
    return egad("design", *more, *common, "--jobs", 1)


def test_the_folder_has_the_hand_the_prints_a_card_and_a_datasheet(folder):
    done = designed("0.09", "--space", "tips.yaml")
    assert done.returncode == 0, done.stderr
    assert "Best grasps: " in done.stdout
    out = folder / "tips"
    hands = [Gripper.from_file(out / name, force=40) for name in ("hand.urdf", "hand.xml")]
    assert hands[0].opening == pytest.approx(hands[1].opening, abs=1e-5)
    card = HandComparison.load(out / "card-mujoco.parquet")
    assert list(card.hands) == ["0.09 m", "0.09 m with tips"]
    text = (out / "datasheet.md").read_text()
    assert "| thickness | 6.0 mm |" in text
    assert f"| opening | 90.0 mm | {1000 * hands[0].opening:.1f} mm |" in text
    rates = card.rates("naive").values()
    before, after = (f"{100 * rate.value:.0f} %" for rate in rates)
    assert f"| naive grasps | {before} | {after} |" in text
    entry = yaml.safe_load((out / "hand.yaml").read_text())["grippers"]["with_tips"]
    assert entry["force"] == 40
    assert entry["file"] == "tips/hand.urdf"
    page = (out / "log.html").read_text()
    sheet = json.loads(re.search(r'id="sheet">(.*?)</script>', page, re.DOTALL)[1])
    assert [each["name"] for each in sheet["detectors"]] == ["before", "after"]
    assert {each["label"] for each in sheet["objects"]} == set(card.table["label"])
    half = 3 * len(sheet["objects"])
    assert [which for *_, which in sheet["order"]] == [0] * half + [1] * half  # mounted once
    expected = {"first_tip.stl", "second_tip.stl", "tips.3mf", "before.png", "after.png"}
    assert expected | {"card-mujoco.html", "designs.parquet"} <= {p.name for p in out.iterdir()}


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["panda", "--space", "bad.yaml"], "tips.length is [0.02, 0.01]; allowed: [LOW, HIGH]"),
        (["panda", "--space", "steep.yaml"], "groove_angle is 80"),
        (["panda", "--space", "mounts.yaml"], "tips.mount is a list; allowed: one"),
        (["panda", "--space", "none.yaml"], "none.yaml"),
        (["cup_30mm", "--space", "tips.yaml"], "the hand cup_30mm has a suction cup and no jaws"),
        (["claw", "--space", "tips.yaml"], "claw"),
    ],
)
def test_a_bad_space_or_hand_is_named(arguments, message):
    done = designed(*arguments)
    assert done.returncode != 0
    assert message in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
