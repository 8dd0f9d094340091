"""`egad trials run`: its table is that of `egad.run_trials`, and holds all that is needed later."""

import pandas as pd
import pytest
import trimesh
from commands import egad

from egad import Gripper, read_mesh, run_trials
from egad.detectors import DetectorConfig
from egad.tables import parquet
from egad.tables.evaluation import TRIALS

CODE = """
from egad.detectors import Grasp

def across(view, gripper, rng):
    points = view.points()[view.heights() > 0.005]
    x, y = points[:, :2].mean(axis=0)
    return [Grasp((x, y, 0.015), rng.uniform(0, 3), gripper.opening, 0.01, 1.0)]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A detector, two meshes in millimetres, and the table of the trials with them."""
    where = tmp_path_factory.mktemp("run")
    (where / "across.py").write_text(CODE)
    (where / "parts").mkdir()
    trimesh.creation.box((30, 60, 30)).export(where / "parts/box.stl")
    trimesh.creation.box((40, 40, 40)).export(where / "parts/cube.stl")
    return where


@pytest.fixture(scope="module")
def table(folder):
    given = [folder / "across.py", "--objects", folder / "parts", "--units", "mm"]
    given += ["--attempts", 2, "--seed", 5, "--gripper", 0.07, "--jobs", 1]
    done = egad("trials", "run", *given, "--out", folder / "across.parquet")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[1].split()[:3] == ["across", "mujoco", "4"]
    assert "attempts: " in done.stdout
    return folder / "across.parquet"


@pytest.mark.parametrize("jobs", [1, 2])
def test_the_table_is_that_of_python(folder, table, tmp_path, jobs):
    meshes = {name: read_mesh(folder / f"parts/{name}.stl", units="mm") for name in ("box", "cube")}
    detect = DetectorConfig(detector=f"{folder / 'across.py'}:across")
    same = run_trials(detect, meshes, Gripper(opening=0.07), attempts=2, seed=5, jobs=jobs)
    parquet.write(same.table, TRIALS, tmp_path / "same.parquet")
    pd.testing.assert_frame_equal(
        *(parquet.read(each, TRIALS) for each in (table, tmp_path / "same.parquet"))
    )


def test_it_is_verified_replayed_and_reported_without_options(table, tmp_path):
    done = egad("trials", "verify", table, "--jobs", 1)
    assert done.returncode == 0, done.stderr
    assert "4 of 4 attempts are the same" in done.stdout
    assert "does not match" not in done.stderr
    film = tmp_path / "film.gif"
    done = egad("trials", "replay", "box", 1, "--table", table, "--out", film)
    assert done.returncode == 0, done.stderr
    assert film.stat().st_size > 0
    page = tmp_path / "page.html"
    done = egad("trials", "report", table, "--out", page)
    assert done.returncode == 0, done.stderr
    assert "across" in page.read_text()
    assert "rank correlation" not in page.read_text()  # the objects are in no grid


def test_other_settings_are_told_to_differ(table, tmp_path):
    changed = tmp_path / "changed.parquet"
    notes = parquet.notes(table)
    notes["run"]["settings"]["seed"] = 6
    parquet.write(parquet.read(table, TRIALS), TRIALS, changed, notes)
    done = egad("trials", "verify", changed, "--jobs", 1)
    assert done.returncode == 1
    assert "attempts are not reproduced" in done.stderr


def test_an_option_replaces_its_own_part_of_the_note(table, tmp_path):
    (tmp_path / "seed.yaml").write_text("seed: 5\ntrials: {attempts: 2}\n")
    done = egad("trials", "verify", table, "--config", tmp_path / "seed.yaml", "--jobs", 1)
    assert done.returncode == 0, done.stderr  # with the meshes and the gripper of the run
    done = egad("trials", "verify", table, "--gripper", "panda", "--jobs", 1)
    assert "are not reproduced" in done.stderr  # the same meshes, for another gripper


def test_relative_paths_hold_in_the_folder_of_the_run(folder, tmp_path, monkeypatch):
    monkeypatch.chdir(folder)
    options = ["--objects", "parts", "--units", "mm", "--attempts", 1, "--gripper", 0.07]
    done = egad("trials", "run", "across.py", *options, "--jobs", 1)
    assert done.returncode == 0, done.stderr
    table = folder / "trials/across.parquet"
    monkeypatch.chdir(tmp_path)
    done = egad("trials", "verify", table)
    assert done.returncode == 1
    assert f"{table}: --objects parts is neither" in done.stderr
    assert "run it in the folder of the run" in done.stderr


def test_mistakes_are_one_sentence(folder, table):
    for arguments, sentence in (
        (["run", "antipodal-cloud"], "in trials, a detector gets a view from above"),
        (["run", folder / "across.py", "--objects", "nowhere"], "neither evaluation-set, released"),
        (["film", "pile", 0, "--table", table], "egad trials replay LABEL ATTEMPT --table"),
    ):
        done = egad("trials", *arguments)
        assert done.returncode == 1
        assert sentence in done.stderr
        assert "Traceback" not in done.stderr
