"""The leaderboard: what was altered, is missing or broken is told, and the rest is ranked."""

import math
import re
import shutil
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import trimesh
from commands import egad as egad_command

import egad
from egad.bench import NAMED_ERRORS, TrialParameters, TrialProtocol, run_attempts
from egad.detectors import Grasp
from egad.geometry import mass_properties
from egad.grippers import GRIPPERS
from egad.sim import model_of
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.evaluation import TRIALS
from egad_workflow import leaderboard
from egad_workflow.leaderboard import (
    ENTRIES,
    ENTRY,
    PROTOCOLS,
    Checks,
    build,
    read_entry,
    read_protocol,
)

SHIPPED = Path(egad.__file__).parents[1] / "leaderboard"
BOX = trimesh.creation.box((0.03, 0.05, 0.03))
OBJECTS = {"id-a": "A0", "id-b": "B1"}
SHORT = {"lift_height": 0.1, "hold_time": 0.2, "errors": "typical"}
PROTOCOL = f"trials: {SHORT | {'attempts': 3}}\n"
ABOUT = "detector: {name}\nby: us\nhardware: a computer\nprotocols: [single]\n"


def across(view, gripper, _rng):
    """Closes on the middle of what is seen above the table, along the shorter side."""
    points = view.points().reshape(-1, 3)
    points = points[points[:, 2] > 0.005]
    middle = points.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov((points - middle)[:, :2].T))
    angle = math.atan2(axes[1, 0], axes[0, 0])
    return [Grasp((*middle[:2], points[:, 2].max()), angle, gripper.opening, 0.02, 1.0)]


def beside(_view, gripper, _rng):
    return [Grasp((0.1, 0.0, 0.03), 0.0, gripper.opening, 0.02, 1.0)]


def model():
    return model_of(BOX, [BOX], mass_properties(BOX, 400.0), 0.0)


@pytest.fixture(scope="module")
def tables():
    trials = TrialProtocol(attempts=3, **SHORT)
    settings = TrialParameters(seed=0, gripper=GRIPPERS["egad_75mm"], trials=trials)
    return {
        detect.__name__: pd.concat(
            run_attempts(model(), label, name, detect, settings) for name, label in OBJECTS.items()
        ).reset_index(drop=True)
        for detect in (across, beside)
    }


@pytest.fixture
def board(tables, tmp_path, monkeypatch):
    """A leaderboard of two objects, with two entries."""
    known = pd.DataFrame({"label": OBJECTS.values(), "id": OBJECTS.keys()})
    monkeypatch.setattr(leaderboard, "load", lambda _: SimpleNamespace(table=known))
    monkeypatch.setattr(
        leaderboard, "evaluation_set_models", lambda *_: dict.fromkeys(OBJECTS, model())
    )
    folder = tmp_path / "leaderboard"
    (folder / PROTOCOLS).mkdir(parents=True)
    (folder / PROTOCOLS / "single.yaml").write_text(PROTOCOL)
    for name, table in tables.items():
        submit(folder, name, table)
    return folder


def submit(folder, name, table, about=ABOUT):
    entry = folder / ENTRIES / name
    entry.mkdir(parents=True)
    (entry / ENTRY).write_text(about.format(name=name))
    if table is not None:
        parquet.write(table, TRIALS, entry / "single.parquet")


def built(folder):
    """The problems that are told, and the text of the page."""
    out = folder.parent / "out"
    problems = build(folder, out, Checks())
    return problems, (out / "index.html").read_text()


@pytest.mark.usefixtures("small_films")
def test_tables_are_verified_ranked_and_filmed(board, tables):
    assert tables["across"]["success"].sum() >= 4
    assert not tables["beside"]["success"].any()
    problems, text = built(board)
    assert problems == []
    assert 'id="entry-across"' in text
    assert "6 of 6 attempts" in text.replace("\N{NARROW NO-BREAK SPACE}", "")
    assert "Not ranked" not in text
    assert text.count("1\N{EN DASH}2") == 2  # two objects cannot tell them apart
    films = sorted(path.name for path in (board.parent / "out/films").iterdir())
    assert any(name.startswith("across-single-") for name in films)
    assert any(name.startswith("beside-single-") for name in films)
    assert all(f"films/{name}" in text for name in films)


def changed(column, value, row=0):
    def change(table):
        table = table.copy()
        table.loc[row, column] = value(table.loc[row, column]) if callable(value) else value
        return table

    return change


def as_success(table):
    """A failure is said to be a success, in both columns."""
    return table.assign(success=True, outcome="success")


ALTERATIONS = {
    "outcomes": (as_success, "6 of 6 attempts are not reproduced"),
    "one outcome": (changed("outcome", "missed"), "success and outcome contradict"),
    "a grasp": (changed("grasp_x", lambda old: old + 1e-3, 4), "B1, attempt 1"),
    "a seed": (changed("seed", "1f" * 16, 2), "A0, attempt 2: seed is"),
    "no seed": (changed("calibration", "zz", 2), "attempt 2: calibration is 'zz'; allowed: a hex"),
    "the engine": (lambda table: table.assign(engine="pybullet"), "the engine is not mujoco"),
    "errors": (lambda table: table.assign(errors="none"), "errors is none, simulated: typical"),
    "an object left out": (lambda table: table.iloc[:3], "B1 (id-b): attempts are missing"),
    "an attempt twice": (
        lambda table: pd.concat([table, table.tail(1)]),
        "B1 (id-b): attempts are missing, duplicated",
    ),
    "another name": (
        lambda table: table.assign(label=table["label"].replace("B1", "C1")),
        "C1 (id-b) is not part of the protocol",
    ),
}


BROKEN = {
    "no-detector": (ABOUT.replace("detector: {name}\n", ""), "detector is missing; allowed: "),
    "no-address": (ABOUT + "link: here\n", "link is 'here'; allowed: an address"),
    "misspelled": (ABOUT + "papper: ours\n", "key 'papper' is not known; did you mean paper?"),
    "no-table": (ABOUT.replace("{name}", "x"), "single.parquet is missing"),
    "no-protocol": (ABOUT.replace("[single]", "[double]"), "there is no protocol double"),
    "a-list": ("- a\n- b\n", "not a table of values"),
    "no-yaml": ("detector: {{\n", "not a YAML file"),
}


def test_altered_tables_are_refused_broken_entries_told_and_the_others_ranked(
    board, tables, monkeypatch
):
    monkeypatch.setattr(leaderboard, "_films", lambda *_: [])
    for name, (change, _) in ALTERATIONS.items():
        table = change(tables["beside" if change is as_success else "across"])
        submit(board, name.replace(" ", "-"), table)
    for name, (about, _) in BROKEN.items():
        submit(board, name, None if name == "no-table" else tables["across"], about)
    problems, text = built(board)
    for name, (_, reason) in ALTERATIONS.items():
        own = [each for each in problems if each.startswith(f"{name.replace(' ', '-')}, single: ")]
        assert len(own) == 1, name
        assert reason in own[0]
    for name, (_, sentence) in BROKEN.items():
        assert any(name in each and sentence in each for each in problems), name
    ranked = set(re.findall(r'href="#entry-([^"]*)"', text))
    assert ranked == {"across", "beside"}
    assert text.count("refused, since") == len(ALTERATIONS)


def test_all_problems_of_an_entry_are_told_at_once(tmp_path):
    (tmp_path / ENTRY).write_text("detektor: mine\nlink: ftp://x\nprotocols: []\n")
    with pytest.raises(egad.UserError) as caught:
        read_entry(tmp_path / ENTRY)
    found = str(caught.value).split("\n")
    assert len(found) == 6
    words = ("detector", "by", "hardware", "protocols", "link", "detektor")
    assert all(any(word in each for each in found) for word in words)


def test_the_exit_code_is_1_if_a_table_is_damaged_or_not_named(
    board, tables, monkeypatch, capsys, tmp_path
):
    monkeypatch.setattr(leaderboard, "_films", lambda *_: [])
    submit(board, "damaged", tables["across"])
    (board / ENTRIES / "damaged/single.parquet").write_bytes(b"PAR1")
    (board / ENTRIES / "no-file").mkdir()
    (board / PROTOCOLS / "wrong.yaml").write_text("trials: {atempts: 3}\n")
    shutil.copy(board / ENTRIES / "across/single.parquet", board / ENTRIES / "across/more.parquet")
    monkeypatch.setattr(
        "sys.argv", ["leaderboard", str(board), "--out", str(tmp_path / "page"), "--jobs", "1"]
    )
    with pytest.raises(SystemExit) as stopped:
        leaderboard.main()
    told = str(stopped.value.code).split("\n")
    assert len(told) == 4
    for name, words in {
        "damaged": "not a readable Parquet file",
        "no-file": "entry.yaml is missing",
        "more.parquet": "does not name the protocol more",
        "wrong.yaml": "trials.atempts: unknown key",
    }.items():
        assert any(name in each and words in each for each in told)
    assert "written" in capsys.readouterr().out
    assert 'href="#entry-beside"' in (tmp_path / "page/index.html").read_text()


def test_the_shipped_entries_can_be_read():
    protocols = {path.stem for path in (SHIPPED / PROTOCOLS).glob("*.yaml")}
    paths = sorted((SHIPPED / ENTRIES).glob(f"*/{ENTRY}"))
    assert len(paths) >= 5
    for path in paths:
        entry = read_entry(path)
        assert set(entry.protocols) <= protocols
        assert sorted(each.stem for each in path.parent.glob("*.parquet")) == sorted(
            entry.protocols
        )
    if find_spec("pybullet") is None:  # it has no packages for newer versions of Python
        protocols.remove("single-pybullet")
    for name in protocols:
        leaderboard.read_protocol(SHIPPED / PROTOCOLS / f"{name}.yaml")


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.usefixtures("small_films")
def test_all_shipped_tables_are_verified(tmp_path):
    assert build(SHIPPED, tmp_path / "out", Checks(sample=10)) == []


@pytest.mark.usefixtures("small_films")
def test_tables_from_python_are_verified_and_replayed(tmp_path):
    objects = egad.load("evaluation-set").select(["A0"])
    made = egad.run_trials(beside, objects, "egad_75mm", 1, errors="typical").table
    config, mine, altered = (tmp_path / name for name in ("mine.yaml", "a.parquet", "b.parquet"))
    config.write_text("trials: {attempts: 1, errors: typical}")
    parquet.write(made, TRIALS, mine)
    parquet.write(made.assign(end_z=made["end_z"] + 1e-3), TRIALS, altered)
    where = ("--in", "evaluation-set", "--config", config)
    verify = ("trials", "verify", "--jobs", 1, *where)
    assert egad_command(*verify, mine).returncode == 0
    film = ("--table", mine, "--out", tmp_path / "film.gif", *where)
    assert egad_command("trials", "replay", "A0", 0, *film).returncode == 0
    assert "1 of 1 attempts are not reproduced" in egad_command(*verify, altered).stderr


@pytest.mark.slow
def test_cleared_tables_from_python_are_filmed(tmp_path):
    objects = egad.load("evaluation-set").select(["A0"])
    given = {"scenes": ["single"], "noise": ["none"], "rounds": 1, "errors": "typical"}
    made = egad.run_benchmark("random", objects, "panda", **given)
    parquet.write(made.table, CLUTTER, tmp_path / "cleared.parquet")
    config, film = tmp_path / "mine.yaml", tmp_path / "film.gif"
    config.write_text("clutter: {scenes: [single], errors: typical}\n")
    words = ("--table", tmp_path / "cleared.parquet", "--in", "evaluation-set", "--config", config)
    where = ("--gripper", "panda", "--out", film)
    assert egad_command("trials", "film", "single", 0, *where, *words).returncode == 0
    assert film.stat().st_size > 10_000


def test_the_example_of_a_submission_runs_what_its_protocol_says(monkeypatch):
    page = (SHIPPED.parent / "docs/leaderboard.md").read_text()
    (call,) = re.findall(r"egad\.run_trials\(\n.*?\n *\)", page, flags=re.DOTALL)
    given = {}
    monkeypatch.setattr(egad, "run_trials", lambda *_, **options: given.update(options))
    eval(call, {"egad": egad, "detect": across})  # noqa: S307 (our own page)
    _, settings = read_protocol(SHIPPED / PROTOCOLS / "single-mujoco.yaml")
    assert given["errors"] == "typical"
    assert settings.trials.errors == NAMED_ERRORS["typical"]
    assert given["attempts"] == settings.trials.attempts
    assert given["depth_noise"] == settings.trials.depth_noise
