"""`egad hands`: what it says and writes."""

import pytest
import trimesh
from commands import egad
from described_hands import box_urdf

from egad.bench.hands import HandComparison
from egad.tables import parquet


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, with meshes in millimetres, and a hand of its own."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "parts").mkdir()
    for name, sides in {"bar": (30, 50, 30), "cube": (90, 90, 90)}.items():
        trimesh.creation.box(sides).export(tmp_path / "parts" / f"{name}.stl")
    (tmp_path / "hand.yaml").write_text("grippers: {mine: {opening: 0.05}}\n")
    return tmp_path


def compared(*more):
    common = ("--objects", "parts", "--units", "mm", "--drops", 1, "--errors", "none", "--jobs", 1)
    return egad("hands", *more, *common)


def test_a_card_is_written_with_the_attempts_beside_it(folder):
    done = compared("panda", "mine", "--config", "hand.yaml", "--out", "card.html", "--films", 1)
    assert done.returncode == 0, done.stderr
    assert "panda never holds cube\n" in done.stdout
    assert "mine never holds cube\n" in done.stdout
    found = HandComparison.load(folder / "card.parquet")
    assert list(found.hands) == ["panda", "mine"]
    assert found.rule == "none"
    assert found.rates()["panda"].successes == 1
    page = (folder / "card.html").read_text()
    assert "mine: 1 object" in page
    assert "at their own size" in page


def test_the_files_of_hands_are_among_what_was_read(folder):
    box_urdf(folder / "boxes.urdf")
    done = compared("boxes.urdf", "--out", "card.html", "--films", 0)
    assert done.returncode == 0, done.stderr
    read = [name for name, _ in parquet.origin_of(folder / "card.parquet")["inputs"]]
    assert read == ["parts/bar.stl", "parts/cube.stl", "boxes.urdf"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["panda", "panda"], "the hand panda is given twice"),
        (["panda", "claw"], "claw"),
        (["0.005"], "the hand 0.005 m opens 5 mm, less than the smallest object, bar, is thick"),
        (["cup_30mm", "--detector", "antipodal-depth"], "the hand cup_30mm: "),
        (["panda", "--engine", "bullet"], "bullet"),
        (["panda", "--out", "card.pdf"], "card.pdf"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_what_cannot_be_compared_is_named(arguments, message):
    done = compared(*arguments)
    assert done.returncode != 0
    assert message in done.stderr
