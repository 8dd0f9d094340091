"""Shards of a search for failures, and their atlas."""

import join_failures
import numpy as np
import pandas as pd
import pytest
import search_failures
from failure_searches import FEW, QUICK, SHAPE, coarse_objects, parts_kept, settings_of

from egad import load
from egad.bench.failures import DetectorFailures, FailureAtlas
from egad.bench.failures import search_failures as whole_search
from egad.errors import UserError
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE
from egad.tables.failures import EXAMINED
from egad_workflow.settings import Settings, select

OWN = """
from egad.detectors import Grasp


def beside(view, gripper, rng):
    return [Grasp((0.1, 0.1, 0.03), float(rng.uniform(0, 3)), gripper.opening, 0.0, 1.0)]


def failing(view, gripper, rng):
    return 1 / 0
"""


@pytest.fixture(autouse=True, scope="module")
def _parts_kept(tmp_path_factory):
    with parts_kept(tmp_path_factory.mktemp("parts")):
        yield


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    path = tmp_path_factory.mktemp("code") / "own.py"
    path.write_text(OWN)
    return path


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """A file with few objects."""
    path = tmp_path_factory.mktemp("dataset") / "archive.parquet"
    few = coarse_objects().archive.iloc[::300]
    parquet.write(few, ARCHIVE, path, {"shape": SHAPE.model_dump(mode="json")})
    return path


@pytest.fixture(scope="module")
def made(own, archive, tmp_path_factory):
    """The folder with what the jobs of a search have written, and the settings."""
    folder, given = tmp_path_factory.mktemp("made"), settings_of(f"{own}:beside", attempts=10)
    for shard in range(2):
        names = {name: folder / f"{name}-{shard}.parquet" for name in ("examined", "attempts")}
        search_failures.run(given, archive, shard, **names)
    parts = {
        name: [folder / f"{name}-{shard}.parquet" for shard in range(2)]
        for name in ("examined", "attempts")
    }
    join_failures.run(given, **parts, failures=folder / "own.parquet", jobs=1)
    return folder, given


def test_the_jobs_find_what_the_library_finds(made, archive):
    """In one process, and with the objects that the table has."""
    folder, given = made
    found = FailureAtlas.load(folder / "own.parquet")
    expected = whole_search(load(archive).archive, given.detector, given)
    assert len(expected.examined) >= 2
    for name in ("table", "examined", "attempts"):
        one, other = getattr(found, name), getattr(expected, name)
        pd.testing.assert_frame_equal(one, other, check_dtype=False)
    assert found.shape == expected.shape


def test_a_detector_that_only_fails_ends_the_job_and_leaves_its_traceback(own, archive, tmp_path):
    out = tmp_path / "examined.parquet"
    with pytest.raises(UserError, match=r"of the first 3 objects\n.* was written to") as stopped:
        given = settings_of(f"{own}:failing", attempts=60, shards=1)
        search_failures.run(given, archive, 0, out, tmp_path / "attempts.parquet")
    kept = tmp_path / "examined.parquet.failure.txt"
    assert str(stopped.value).endswith(str(kept))
    assert kept.read_text(encoding="utf-8").endswith("ZeroDivisionError: division by zero\n")
    assert not out.exists()


def test_objects_of_other_shapes_are_refused(own, archive, tmp_path):
    detectors = {"own": {"detector": f"{own}:beside"}}
    whole = {"failures": FEW, "detectors": detectors} | QUICK | {"shape": {"resolution": 30}}
    other = select(Settings.model_validate(whole), DetectorFailures, "panda", "own")
    with pytest.raises(UserError, match=r"shape.resolution: 10 in the archive, 30"):
        search_failures.run(other, archive, 0, tmp_path / "a.parquet", tmp_path / "b.parquet")


def test_objects_that_were_measured_otherwise_are_measured_again(own, tmp_path):
    few = coarse_objects().archive.iloc[:1].assign(graspability=0.1)
    given = settings_of(f"{own}:beside", attempts=1, shards=1)
    notes = {"graspability": given.breeding.graspability.model_dump(mode="json")}
    paths = [tmp_path / f"{name}.parquet" for name in ("archive", "examined", "attempts")]
    found = []
    for candidates in (given.breeding.graspability.candidates, 7):
        notes["graspability"] = notes["graspability"] | {"candidates": candidates}
        notes["shape"] = given.breeding.shape.model_dump(mode="json")
        parquet.write(few, ARCHIVE, paths[0], notes)
        search_failures.run(given, paths[0], 0, *paths[1:])
        found.append(parquet.read(paths[1], EXAMINED)["graspability"].iloc[0])
    assert found[0] == 0.1
    assert np.isfinite(found[1])
    assert found[1] < 0.01
