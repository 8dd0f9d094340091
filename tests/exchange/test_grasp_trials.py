"""Grasps of others, tried in simulation: outcomes that can be told in advance, and their table."""

import numpy as np
import pandas as pd
import pytest
import trimesh
from described_hands import jaw_urdf
from worlds import EACH_FAST_ENGINE

import egad
from egad.bench.stats import wilson
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


def try_middle(tmp_path, engine="mujoco", **levels):
    """Two grasps across the middle of a cube by a hand of 5 N."""
    poses = hand_poses(np.zeros((2, 3)), np.tile(ACROSS, (2, 1)), np.array([DOWN, (0, 1, 0)]))
    np.savez(tmp_path / "a.npz", poses=poses, success=[1, 1], frame="x z", depth=0.0, units="m")
    hand = egad.Gripper(opening=0.08, force=5.0)
    grasps = egad.read_grasps(tmp_path / "a.npz", mesh=CUBE, gripper=hand)
    return egad.try_grasps(grasps, CUBE, hand, engine=engine, **levels)


@EACH_FAST_ENGINE
def test_two_fingers_hold_what_coulomb_friction_can_carry(engine, tmp_path):
    """Their friction carries at most 2 x friction x force, far from the weight."""
    levels = {"friction": [0.14, 0.5, 1.8], "mass": [0.05, 0.25, 0.9]}
    tried = try_middle(tmp_path, engine, **levels)
    table = tried.table
    assert len(table) == 18
    weight, carried = 9.81 * table["mass"], 2 * table["friction"] * 5.0
    assert (np.abs(np.log(carried / weight)) > np.log(1.7)).all()
    for place in ("simulated_outcome", "table_outcome"):
        assert ((table[place] == "success") == (carried > weight)).all()
    for column, values in levels.items():
        found = tried.by(column, "table")
        assert found[column].astype(float).tolist() == values
        held = (carried > weight).groupby(table[column]).mean()
        assert found["simulated"].tolist() == found["agreement"].tolist() == held.tolist()
    assert "friction 0.14 to 1.8, mass 0.05 to 0.9 kg" in repr(tried)


def test_each_friction_and_mass_is_tried_as_if_alone(tmp_path):
    tried = try_middle(tmp_path, friction=np.array([0.3, 0.6]), mass=(0.1, 0.2))
    assert "2 grasps at 4 frictions and masses (8 trials, counted below) in mujoco, 2 coll" in repr(
        tried
    )
    whole = tried.table
    for friction in (0.3, 0.6):
        rows = whole[(whole["friction"] == friction) & (whole["mass"] == 0.2)]
        alone = try_middle(tmp_path, friction=friction, mass=0.2).table
        pd.testing.assert_frame_equal(rows.reset_index(drop=True), alone)
    usual = try_middle(tmp_path).table
    assert set(usual["friction"]) == {0.5}
    assert set(usual["mass"]) == {0.05}  # 400 kg/m3 would be 26 g


def test_more_levels_do_not_make_intervals_narrower():
    rng = np.random.default_rng(1)
    labels, held = rng.random((2, 60)) < 0.6
    outcome = np.where(held, "success", "missed")
    one = pd.DataFrame({"simulated_outcome": outcome, "source_success": labels.astype(float)})
    one = one.assign(label="a", mass=1.0, source_score=rng.random(60))
    tables = [one.assign(friction=friction) for friction in (0.2, 0.4, 0.8)]
    first, whole = GraspTrials(tables[0]), GraspTrials(pd.concat(tables))
    assert whole.agreement().interval == first.agreement().interval
    assert whole.area().interval == pytest.approx(first.area().interval)
    ends = np.diff([first.rate().interval, whole.rate().interval])[:, 0]
    assert ends[1] > 0.9 * ends[0]
    for outcome in ("success", "missed"):  # nothing varies
        for objects in (["a"] * 60, ["a", "b"] * 30):
            known = {"simulated_outcome": outcome, "label": objects}
            few = GraspTrials(first.table.assign(**known))
            many = GraspTrials(whole.table.assign(**known | {"label": objects * 3}))
            assert many.rate().interval == few.rate().interval == wilson(few.rate().successes, 60)


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
    assert lost.empty
    table.loc[1, "width"] = np.nan
    assert GraspTrials(table).by("width")["grasps"].tolist() == [1, 1, 1, 1, 1]
    with pytest.raises(UserError, match="known: source_success, width"):
        GraspTrials(table).by("table_outcome")


def test_intervals_are_over_objects_if_there_are_several():
    rng = np.random.default_rng(0)
    table = pd.DataFrame({"grasp": range(600), "label": np.repeat(list("abcdef"), 100)})
    score = rng.random(600)
    outcomes = np.where(rng.random(600) < score, "success", "missed")
    table = table.assign(
        source_score=score, friction=0.5, mass=0.1, source_success=(score > 0.5).astype(float)
    )
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
    for wrong in (0, 2.1, "0.5", [0.5, -1], [], np.array([0.5, np.nan]), np.ones((2, 2))):
        sentence = r"(?s)friction is .*; allowed: numbers above 0 to 2, one or more"
        with pytest.raises(UserError, match=sentence):
            egad.try_grasps(read, CUBE, "panda", friction=wrong)
    with pytest.raises(
        UserError, match=r"mass is 0\.01; allowed: numbers from 0\.05 to 100, one or more"
    ):
        egad.try_grasps(read, CUBE, "panda", mass=0.01)
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
