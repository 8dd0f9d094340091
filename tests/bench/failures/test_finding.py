"""`egad.find_failures`: the same for any number of jobs, resumed, and kept in a folder."""

import pandas as pd
import pytest
from failing import CUBE, QUICK, beside
from failure_searches import coarse_objects

import egad
from egad.bench.failures import FailureAtlas, FailureSearch, finding
from egad.bench.failures.examine import approach_of
from egad.detectors import IN_SCENES, DetectorConfig

FEW = coarse_objects()[["C03_0", "H01_2", "E03_0", "G03_0"]]


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Weaker claims, which few attempts can show."""
    search = finding.FailureSearch
    for name, value in QUICK.items():
        monkeypatch.setattr(search.model_fields[name], "default", value)
    search.model_rebuild(force=True)
    yield
    monkeypatch.undo()
    search.model_rebuild(force=True)


def found(**options):
    arguments = {"objects": FEW, "attempts": 13, "strategy": "screening", "engines": ["mujoco"]}
    arguments |= options
    return egad.find_failures(arguments.pop("detector", beside), **arguments)


def test_an_atlas_has_its_objects_and_says_how_it_was_found(tmp_path):
    atlas = found(out=tmp_path / "atlas")
    assert 0 < len(atlas) == len(atlas.objects) <= len(FEW)
    assert set(atlas.objects.table["id"]) <= set(FEW.table["id"])
    name = atlas.table["id"].iloc[0]
    assert atlas.objects[name].mesh.vertices == pytest.approx(FEW[name].mesh.vertices)
    assert f"{len(atlas)} failures in {atlas.cells} cells" in repr(atlas)
    assert (atlas.table["difference_mujoco"] == 1).all()
    assert (atlas.table["n_none_good"] == atlas.table["n_explained"]).all()
    assert atlas.failure_rate().successes == len(atlas)
    again = FailureAtlas.load(tmp_path / "atlas")
    pd.testing.assert_frame_equal(again.table, atlas.table, check_dtype=False)
    read = egad.load(tmp_path / "atlas/failures.parquet").table
    pd.testing.assert_frame_equal(read, atlas.objects.table, check_dtype=False)


@pytest.mark.slow
def test_it_does_not_depend_on_processes_nor_on_interruptions(tmp_path):
    options = {"attempts": 120, "strategy": "evolution", "shards": 2}
    first = found(out=tmp_path / "a", **options)
    found(out=tmp_path / "b", jobs=2, **options)
    names = [path.relative_to(tmp_path / "a") for path in (tmp_path / "a").rglob("*.parquet")]
    assert len(names) == 7
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    pd.testing.assert_frame_equal(
        found(out=tmp_path / "a", **options).table, first.table, check_dtype=False
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"detector": "labels"}, "labels"),
        ({"detector": DetectorConfig(detector="labels")}, "as the reference does"),
        ({"detector": "suction-depth"}, "suction cups"),
        ({"detector": 3}, "a detector is a function"),
        ({"attempts": 0}, "attempts"),
        ({"objects": {"cube": CUBE}}, "meshes"),
    ],
)
def test_what_cannot_be_searched_with_is_told(arguments, words):
    with pytest.raises(egad.UserError, match=words):
        found(**arguments)


def test_the_input_of_a_detector_says_how_it_grasps():
    search = FailureSearch()
    assert approach_of(beside, search) == "above"
    assert approach_of(IN_SCENES["antipodal-depth"], search) == "above"
    assert approach_of(IN_SCENES["antipodal-cloud"], search) == "any"
    assert approach_of(lambda cloud, gripper, rng: [], search) == "any"  # noqa: ARG005
    assert approach_of(beside, FailureSearch(approach="any")) == "any"
    with pytest.raises(egad.UserError, match="asks for `cloud`"):
        approach_of(IN_SCENES["antipodal-cloud"], FailureSearch(approach="above"))
