"""Grasps of others, tried in simulation: outcomes that can be told in advance, and their table."""

import numpy as np
import pandas as pd
import pytest
import trimesh
from described_hands import jaw_urdf
from worlds import EACH_FAST_ENGINE

import egad
from egad.errors import UserError
from egad.exchange.grasp_trials import GraspTrials, fingertip_depths
from egad.grasps import hand_poses
from egad.tables import parquet
from egad.tables.grasping import TRIED_GRASPS

CUBE = trimesh.creation.box((0.04,) * 3)
DOWN, ACROSS = (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)
PLACES = {  # center and approach of grasps that close along x, and how they end
    "middle": ((0, 0, 0), DOWN, "success"),
    "from the side": ((0, 0, 0), (0.0, 1.0, 0.0), "success"),
    "beside": ((0, 0.1, 0), DOWN, "missed"),
    "off center": ((0.035, 0, 0), DOWN, "collided"),
    "palm in the object": ((0, 0, -0.03), DOWN, "collided"),
}


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    """The grasps above, read from a file with labels, of which the last is wrong, and scores."""
    path = tmp_path_factory.mktemp("grasps") / "cube.npz"
    centers, approaches = (np.array([each[n] for each in PLACES.values()]) for n in (0, 1))
    poses = hand_poses(centers, np.tile(ACROSS, (len(PLACES), 1)), approaches)
    labels, scores = [1, 1, 0, 0, 1], [0.9, 0.8, 0.3, 0.2, 0.1]
    np.savez(path, poses=poses, success=labels, score=scores)
    said = {"frame": "x z", "depth": 0, "units": "m"}
    return egad.read_grasps(path, mesh=CUBE, gripper="panda", **said)


@EACH_FAST_ENGINE
def test_outcomes_are_as_expected_and_labels_are_compared(engine, read):
    tried = egad.try_grasps(read, CUBE, "panda", name="cube", engine=engine)
    expected = [each[2] for each in PLACES.values()]
    table = tried.table
    assert table["simulated_outcome"].tolist() == expected
    assert table["table_outcome"].tolist() == expected
    assert set(table["label"]) == {"cube"}
    assert table["collision_free"].astype(bool).tolist() == [True, True, True, False, False]
    for place in ("free", "table"):
        found = tried.agreement(place)
        counts = (found.both, found.only_first, found.only_second, found.neither)
        assert counts == (2, 1, 0, 2)
        assert found.value == pytest.approx((0.8 - 0.48) / 0.52)
        assert tried.area(place=place).value == 1
        assert tried.rate(place).successes == 2
    text = repr(tried)
    assert f"5 grasps in {engine}, 3 collision-free" in text
    assert "labels agree 80%: both succeed 2, only the label 1, only simulated 0" in text
    assert "over grasps" in text


def test_processes_change_nothing_and_grasps_are_evenly_spaced(tmp_path):
    box = trimesh.creation.box((0.03, 0.05, 0.08))
    grasps = egad.sample_grasps(box, "panda", n=46)
    one, two = (egad.try_grasps(grasps, box, "panda", n=24, jobs=jobs) for jobs in (1, 2))
    pd.testing.assert_frame_equal(one.table, two.table)
    assert one.table["grasp"].tolist() == np.linspace(0, 45, 24).round().astype(int).tolist()
    assert one.rate().value > 0.9
    assert one.rate("table").value > 0.4
    assert not one.agreement().agreement.attempts
    parquet.write(one.table, TRIED_GRASPS, tmp_path / "a.parquet")
    back = parquet.read(tmp_path / "a.parquet", TRIED_GRASPS)
    assert back["table_outcome"].tolist() == one.table["table_outcome"].tolist()


@pytest.mark.parametrize("kind", ["robotiq_2f_85", "swinging jaw"])
def test_hands_of_other_kinds_lift_what_they_reach(kind, tmp_path):
    """One moves both fingers; of the other, one is fixed and the other swings."""
    if kind == "swinging jaw":
        hand = egad.Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf"), force=40.0)
    else:
        hand = egad.gripper(kind)
    box = trimesh.creation.box((0.03, 0.05, 0.08))
    tried = egad.try_grasps(egad.sample_grasps(box, hand, n=20), box, hand)
    free = GraspTrials(tried.table[tried.table["collision_free"].astype(bool)])
    assert free.rate().value > 0.9
    assert free.rate("table").value > 0.5


def test_a_ball_is_put_down_so_that_each_grasp_comes_from_above():
    ball = trimesh.creation.icosphere(3, 0.025)
    tried = egad.try_grasps(egad.sample_grasps(ball, "panda", n=10), ball, "panda")
    assert set(tried.table["table_outcome"]) == {"success"}


def test_depth_is_that_of_the_fingertips_below_the_surface(read):
    """The fingertips of a Panda are 10.5 mm beyond the contacts, half of 21 mm."""
    found = fingertip_depths(CUBE, read.to_frame(), egad.gripper("panda"))
    assert found == pytest.approx(np.array([0.0305, 0.0305, 0, 0, 0.0445]), abs=1e-6)


def test_terciles_are_those_of_a_table_that_is_counted_by_hand():
    row = {"simulated_outcome": "success", "table_outcome": "success", "label": "a"}
    table = pd.DataFrame([row] * 7).assign(
        width=[0.07, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06], source_success=[0, 1, 1, 0, 1, 1, np.nan]
    )
    table.loc[[0, 2], "simulated_outcome"] = "missed"
    table.loc[5, "simulated_outcome"] = "crashed"  # the engine cannot tell
    found = GraspTrials(table).by("width")
    assert found["grasps"].tolist() == [2, 2, 2]
    assert found["from"].tolist() == [0.01, 0.03, 0.06]
    assert found["to"].tolist() == [0.02, 0.04, 0.07]
    assert found["labelled"].tolist() == [1, 0.5, 0]
    assert found["simulated"].tolist() == [0.5, 1, 0.5]
    assert found["agreement"].tolist() == [0.5, 0.5, 1]
    lost = GraspTrials(table.assign(simulated_outcome="crashed")).by("width")
    assert lost["grasps"].tolist() == [0, 0, 0]
    assert lost[["simulated", "agreement"]].isna().all(axis=None)
    with pytest.raises(UserError, match="known: source_success, width"):
        GraspTrials(table).by("table_outcome")


def test_intervals_are_over_objects_if_there_are_several():
    rng = np.random.default_rng(0)
    table = pd.DataFrame({"grasp": range(600), "label": np.repeat(list("abcdef"), 100)})
    score = rng.random(600)
    outcomes = np.where(rng.random(600) < score, "success", "missed")
    table = table.assign(source_score=score, source_success=(score > 0.5).astype(float))
    tried = GraspTrials(table.assign(simulated_outcome=outcomes, table_outcome=outcomes))
    assert tried.unit == "objects"
    assert tried.area().interval[0] < tried.area().value < tried.area().interval[1]
    same = GraspTrials(tried.table.assign(label="a", grasp=0))
    assert (same.unit, same.agreement().value) == ("grasps", tried.agreement().value)
    assert same.agreement().interval != tried.agreement().interval
    assert same.area().interval[1] - same.area().interval[0] > 0.02


def test_what_cannot_be_tried_is_refused(read, tmp_path):
    with pytest.raises(UserError, match=r"a grasp that is tried.*suction cup"):
        egad.try_grasps(read, CUBE, "cup_30mm")
    with pytest.raises(UserError, match="n is 1001; allowed: a whole number from 1 to 1000"):
        egad.try_grasps(read, CUBE, "panda", n=1001)
    with pytest.raises(UserError, match="rating 'speed' is not known"):
        GraspTrials(read.to_frame().assign(label="cube")).area("speed")
    np.savez(tmp_path / "a.npz", poses=np.eye(4)[None], widths=[0.04])
    said = {"frame": "x z", "depth": 0, "units": "m"}
    with pytest.raises(UserError, match="no quality: it is computed"):
        egad.try_grasps(egad.read_grasps(tmp_path / "a.npz", **said), CUBE, "panda")


def test_labels_that_egad_simulated_are_confirmed(tmp_path):
    """A weak hand loses a rod that it holds near an end, some only when it lifts it."""
    rod = trimesh.creation.cylinder(0.012, 0.24, sections=24)
    rod.apply_transform(trimesh.transformations.rotation_matrix(0.5, (1, 1, 0)))
    hand = egad.Gripper(opening=0.08, force=1.0)
    done = egad.export({"rod": rod}, "acronym", hand, tmp_path / "out", grasps=40, rule="none")
    read = egad.read_grasps(next(done.folder.rglob("*.h5")), mesh=rod, gripper=hand)
    tried = egad.try_grasps(read, rod, hand)
    found = tried.agreement()
    assert min(found.both, found.neither) > 4
    assert found.value == 1
    assert tried.rate().successes > (tried.table["simulated_outcome"] == "success").sum()
