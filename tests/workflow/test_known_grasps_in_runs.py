"""Grasps of files in a configuration: they are tried, recorded, and stale when they change."""

import numpy as np
import pytest
import trimesh

from egad.grasps import hand_poses
from egad.io import checksum
from egad.tables import parquet
from egad.tables.evaluation import TRIALS
from egad_workflow.provenance import origin_of

TABLE = "results/mine/trials/egad_75mm/known.parquet"
TRIED = {"simulated_trial": 1, "join_trials": 1}


def write_grasps(path, place):
    """Grasps of a bar from all four sides, at a place along it."""
    up, across = np.eye(3)[2], np.eye(3)[1]
    sides = [(across, -up), (across, up), (up, across), (up, -across)]
    poses = hand_poses(np.full((4, 3), [place, 0, 0]), *np.swapaxes(sides, 0, 1))
    path.parent.mkdir(exist_ok=True)
    np.savez(path, poses=poses, frame="x z", depth=0.0, units="m")


@pytest.fixture
def configs(clean):
    """Makes configurations that try grasps on a bar and on a rod, in a clean checkout."""
    (clean.folder / "parts").mkdir()
    trimesh.creation.box((0.12, 0.03, 0.03)).export(clean.folder / "parts/bar.stl")

    def made(detector, rule="none"):
        mine = {"source": "meshes", "folder": "parts", "units": "m"}
        settings = {
            "shards": 1,
            "datasets": {"mine": mine},
            "detectors": {"known": {"detector": detector}},
            "targets": {"datasets": ["mine"], "detectors": ["known"]},
            "trials": {"attempts": 2},
            "rescale": {"rule": rule},
        }
        return ["config/test.yaml", clean.overlay("own.yaml", settings)]

    return made


@pytest.mark.slow
def test_grasps_of_files_are_tried_recorded_and_stale_when_they_change(clean, configs):
    """The second file has grasps at the end of the bar, where the trials then take hold of it."""
    file = clean.folder / "my grasps/bar.npz"
    write_grasps(file, 0.0)
    folder = configs("grasps:my grasps")
    clean.make("--cores", 2, TABLE, configs=folder)
    trials = parquet.read(clean.folder / TABLE, TRIALS)
    assert trials["outcome"].tolist() == ["success"] * 2
    part = clean.folder / "results/mine/parts/trials-egad_75mm-known-0.parquet"
    assert {path.name: digest for path, digest in origin_of(part).sources()}["bar.npz"] == (
        checksum(file)
    )
    (file.parent / "notes.txt").touch()
    assert clean.planned(TABLE, configs=folder) == {}
    write_grasps(file, 0.04)
    assert clean.planned(TABLE, configs=folder) == TRIED
    clean.make("--cores", 2, TABLE, configs=configs("grasps:my grasps/bar.npz"))
    moved = parquet.read(clean.folder / TABLE, TRIALS)
    shift = moved[["grasp_x", "grasp_y", "grasp_z"]] - trials[["grasp_x", "grasp_y", "grasp_z"]]
    assert np.linalg.norm(shift, axis=1) == pytest.approx([0.04] * 2, abs=1e-3)


def test_missing_grasps_and_scaled_meshes_are_named(clean, configs):
    status, said = clean.snakemake("--dry-run", TABLE, configs=configs("grasps:none/bar.npz"))
    assert status != 0
    assert "detectors.known: none/bar.npz is neither a file of grasps nor a folder of them" in said
    write_grasps(clean.folder / "grasps/rod.npz", 0.0)
    _, said = clean.snakemake("--dry-run", TABLE, configs=configs("grasps:grasps", "paper"))
    assert "rescale.rule: it is paper; with the grasps of meshes, known, it is none" in said
