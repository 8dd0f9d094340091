"""`egad failures`: what it says and writes."""

import re

import pytest
import yaml
from commands import egad
from failure_searches import FEW, QUICK, SHAPE, coarse_objects, parts_kept
from partial_tables import write_rows

from egad._util.progress import MARKS
from egad.bench.failures import FailureAtlas, ObjectVerdict
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE
from egad.tables.objects import OBJECTS

OWN = """
from egad.detectors import Grasp


def beside(view, gripper, rng):
    return [Grasp((0.1, 0.1, 0.03), float(rng.uniform(0, 3)), gripper.opening, 0.0, 1.0)]
"""


@pytest.fixture(autouse=True, scope="module")
def _parts_kept(tmp_path_factory):
    with parts_kept(tmp_path_factory.mktemp("parts")):
        yield


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, with a detector, a configuration and few objects."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beside.py").write_text(OWN)
    (tmp_path / "few.yaml").write_text(yaml.safe_dump({"failures": FEW, **QUICK}))
    notes = {"shape": SHAPE.model_dump(mode="json")}
    parquet.write(coarse_objects().archive.iloc[::300], ARCHIVE, tmp_path / "few.parquet", notes)
    return tmp_path


def search(detector, *more):
    common = ("--config", "few.yaml", "--objects", "few.parquet", "--jobs", 1)
    return egad("failures", detector, *common, *more)


def test_a_search_tells_what_it_found_and_where_and_its_progress_in_attempts(folder, monkeypatch):
    monkeypatch.setenv(MARKS, "1")  # progress of short work too
    done = search("beside.py", "--attempts", 12, "--films", 0)
    assert done.returncode == 0, done.stderr
    atlas = FailureAtlas.load(folder / "failures/beside")
    attempts, objects = int(atlas.examined["attempts"].sum()), len(atlas.examined)
    first, second, third, *verdicts = done.stdout.splitlines()[:-4]
    assert first == f"failures of beside: {len(atlas)}, in {atlas.cells} cells"
    assert second == f"attempts: {attempts}, at {objects} objects"
    assert third == f"objects: {objects}"
    assert sum(int(line.split()[0]) for line in verdicts) == objects
    assert f"{len(atlas):6} failure: {ObjectVerdict.FAILURE.meaning}" in verdicts
    assert "failures/beside/attempts.parquet: the attempts\n" in done.stdout
    assert (folder / "failures/beside/index.html").read_text().startswith("<!DOCTYPE html>")
    assert re.search(r"^attempts: \d+/12", done.stderr, re.MULTILINE)
    noted = parquet.origin_of(folder / "failures/beside/failures.parquet")
    assert noted["stage"] == "failures"
    assert "few.parquet" in str(noted["inputs"])

    again = search("beside.py", "--attempts", 12, "--films", 0)
    assert again.stdout == done.stdout
    other = search("beside.py", "--attempts", 13)
    assert other.returncode == 1
    assert other.stderr == (
        "egad: failures/beside holds another search (other settings); choose another folder, or "
        "delete this one\n"
    )


def test_options_are_settings(folder):
    options = {
        "--attempts": 1,
        "--strategy": "screening",
        "--approach": "above",
        "--depth-noise": 0.5,
        "--least-difference": 0.4,
        "--engines": "pybullet,mujoco",
        "--rule": "exact",
        "--gripper": 0.07,
    }
    words = [str(word) for pair in options.items() for word in pair]
    done = search("beside.py", *words, "--out", "atlas")
    assert done.returncode == 0, done.stderr
    settings = parquet.notes(folder / "atlas/shard-0/examined.parquet")["settings"]
    named = ("attempts", "strategy", "approach", "depth_noise", "least_difference", "engines")
    values = [settings["failures"][name] for name in named]
    assert values == [1, "screening", "above", 0.5, 0.4, ["pybullet", "mujoco"]]
    assert settings["gripper"]["opening"] == 0.07
    assert settings["rescale"]["rule"] == "exact"
    assert settings["failures"]["confirm"] == FEW["confirm"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("labels", "the detector labels knows where objects lie, as the reference does"),
        ("suction-depth", "the detector suction-depth is for suction cups; the gripper has jaws"),
        ("random --gripper cup_30mm", "the detector random is for jaws; the gripper has a suction"),
        ("antipodal-cloud --approach above", "the detector asks for `cloud`, but for grasps from"),
        ("nowhere.py", "there is no file nowhere.py"),
        ("random --objects nowhere", "--objects nowhere: nowhere is neither 'released', nor"),
        ("random --objects meshes", "--objects meshes: these objects come from meshes"),
        ("random --engines mujoco,bullet", '--engines: failures.engines.1: "bullet" is not'),
        ("random --depth-noise 99", "--depth-noise: failures.depth_noise: 99.0 is not allowed"),
        ("random --weights few.yaml", "the detector random takes no `weights`"),
    ],
)
def test_what_cannot_be_searched_is_one_sentence(folder, words, said):
    if "meshes" in words:
        _dataset_of_meshes(folder / "meshes")
    detector, *more = words.split()
    done = search(detector, *more)
    assert done.returncode == 1
    *_, last = done.stderr.splitlines()
    assert last.startswith(f"egad: {said}")
    assert "Traceback" not in done.stderr


def _dataset_of_meshes(folder):
    folder.mkdir()
    write_rows(OBJECTS, [{"id": "box", "label": "A0_0"}], folder / "objects.parquet")
