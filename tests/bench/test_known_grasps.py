"""Grasps that are known before, such as those of a file, tried by `labels` wherever objects lie."""

import numpy as np
import pytest
import trimesh

import egad
from egad.detectors import DetectorConfig
from egad.errors import UserError
from egad.grasps import hand_poses

BAR = trimesh.creation.box((0.12, 0.03, 0.03))
RUN = {"gripper": "panda", "attempts": 2, "rule": "none", "seed": 1}


def known(tmp_path, places, **about):
    """Grasps of the bar from all four sides at some places along it, as a file has them."""
    up, across = np.eye(3)[2], np.eye(3)[1]
    sides = [(across, -up), (across, up), (up, across), (up, -across)]
    rows = [((x, 0.0, 0.0), *side) for x in places for side in sides]
    centers, axes, approaches = (np.array([row[n] for row in rows]) for n in range(3))
    columns = {name: np.repeat(values, len(sides)) for name, values in about.items()}
    np.savez(
        tmp_path / "bar.npz",
        poses=hand_poses(centers, axes, approaches),
        frame="x z",
        depth=0.0,
        units="m",
        **columns,
    )
    return egad.read_grasps(tmp_path / "bar.npz", mesh=BAR, gripper="panda")


def test_grasps_of_a_file_lift_the_object_wherever_it_lies(tmp_path):
    grasps = {"bar": known(tmp_path, [0.0, 0.02])}
    trials = egad.run_trials("labels", {"bar": BAR}, **RUN, grasps=grasps)
    assert trials.table["outcome"].tolist() == ["success"] * 2
    both = [egad.run_trials("labels", {"bar": BAR}, **RUN, grasps=grasps, jobs=n) for n in (1, 2)]
    assert both[0].table.equals(both[1].table)


def test_the_score_of_the_file_ranks_them(tmp_path):
    """The same drop, but the file prefers places on the bar that are 4 cm apart."""
    places = []
    for scores in ([1.0, 0.5], [0.5, 1.0]):
        grasps = {"bar": known(tmp_path, [0.0, 0.04], score=scores)}
        first = egad.run_trials("labels", {"bar": BAR}, **RUN, grasps=grasps).table.iloc[0]
        assert first["quality"] == 1.0
        places.append(first[["grasp_x", "grasp_y", "grasp_z"]].to_numpy(float))
    assert np.linalg.norm(places[0] - places[1]) == pytest.approx(0.04, abs=1e-3)


def test_what_the_file_calls_failures_is_not_tried(tmp_path):
    grasps = {"bar": known(tmp_path, [0.0], success=[0.0])}
    table = egad.run_trials("labels", {"bar": BAR}, **RUN, grasps=grasps, keep_going=True).table
    assert set(table["outcome"]) == {"no_grasp"}


def test_tables_are_cleared_with_them(tmp_path):
    grasps = {"bar": known(tmp_path, [0.0])}
    options = {"scenes": ["single"], "noise": ["none"], "rounds": 2, "rule": "none"}
    found = egad.run_benchmark("labels", {"bar": BAR}, **options, grasps=grasps)
    assert found.table["outcome"].tolist() == ["success"] * 2


def test_wrong_uses_are_refused(tmp_path):
    grasps, bar = known(tmp_path, [0.0]), {"bar": BAR}
    wide = {**np.load(tmp_path / "bar.npz"), "widths": np.full(len(grasps), 0.03)}
    np.savez(tmp_path / "wide.npz", **wide)
    bare = egad.read_grasps(tmp_path / "wide.npz")
    with pytest.raises(UserError, match="quality"):
        egad.run_trials("labels", bar, **RUN, grasps={"bar": bare})
    with pytest.raises(UserError, match="grasps are for the detector labels"):
        egad.run_trials("random", bar, **RUN, grasps={"bar": grasps})
    with pytest.raises(UserError, match=r"grasps:bar\.npz: in Python, give labels the `grasps`"):
        egad.run_trials(DetectorConfig(detector="grasps:bar.npz"), bar, **RUN)
    with pytest.raises(UserError, match="rule is 'paper'; with grasps, it is 'none'"):
        egad.run_trials("labels", bar, **RUN | {"rule": "paper"}, grasps={"bar": grasps})
    with pytest.raises(UserError, match="no grasps of 'bar'; there are some of mug"):
        egad.run_benchmark("labels", bar, rule="none", grasps={"mug": grasps})
