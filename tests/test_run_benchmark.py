"""Detectors clear tables from Python."""

import numpy as np
import pytest
import trimesh

import egad
from egad.detectors import GraspPoses
from egad.errors import UserError
from egad.pipeline.config import GRIPPERS
from egad.sim import Clutter, ClutterParameters, build, repeat_round, rounds_of
from egad.sim.rounds import read_grasp
from egad.tables import parquet
from egad.tables.clutter import CLUTTER

SIZES = [(0.03, 0.04, 0.05), (0.04, 0.04, 0.04), (0.03, 0.03, 0.08), (0.05, 0.03, 0.03)]
OBJECTS = {f"box{number}": trimesh.creation.box(sizes) for number, sizes in enumerate(SIZES)}
FEW = {"rounds": 2, "per_scene": 3, "rule": "none", "noise": ["none"]}


def nothing(_view, _gripper, _rng):
    return []


def at_the_highest_point(cloud, gripper, _rng):
    point = cloud.points[cloud.points[:, 2].argmax()] - [0, 0, 0.01]
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = point
    return GraspPoses(pose[None], np.array([gripper.opening]), np.ones(1))


@pytest.fixture(scope="module")
def first():
    return egad.run_benchmark(at_the_highest_point, OBJECTS, **FEW)


def test_the_table_has_a_row_per_attempt(first, tmp_path):
    table = first.table
    assert list(table.columns) == CLUTTER.names
    parquet.write(table, CLUTTER, tmp_path / "table.parquet")
    rounds = table.groupby(["scene", "round"])
    assert set(table["scene"]) == {"single", "packed", "pile"}
    assert len(rounds) == 6
    for (scene, _), rows in rounds:
        assert rows["attempt"].tolist() == list(range(len(rows)))
        assert (rows["n_objects"] == (1 if scene == "single" else 3)).all()
        assert len(rows["objects"].iloc[0].split()) == rows["n_objects"].iloc[0]
        left = rows["n_objects"].iloc[0] - rows["success"].cumsum().shift(fill_value=0)
        assert (rows["n_present"] <= left).all()
        assert rows["id"].isin(OBJECTS).all()
    assert table["success"].any()


def test_jobs_change_nothing(first):
    again = egad.run_benchmark(at_the_highest_point, OBJECTS, jobs=2, **FEW)
    assert first.table.equals(again.table)


def test_all_detectors_meet_the_same_scenes(first):
    other = egad.run_benchmark(nothing, OBJECTS, **FEW).table
    assert (other["outcome"] == "no_grasp").all()
    mine = first.table[first.table["attempt"] == 0]
    for name in ("scene", "round", "seed", "objects", "n_objects"):
        assert mine[name].tolist() == other[name].tolist()


def test_another_seed_is_another_scene(first):
    other = egad.run_benchmark(at_the_highest_point, OBJECTS, seed=1, **FEW).table
    assert set(other["seed"]).isdisjoint(first.table["seed"])


def test_a_round_is_repeated_from_its_rows(first):
    clutter = Clutter(rounds=2, objects=3, noise=("none",), scale=(0.8, 1.0))
    settings = ClutterParameters(seed=0, gripper=GRIPPERS["panda"], clutter=clutter)
    models = {name: build(mesh, 400.0, egad.evalset.Bundle()) for name, mesh in OBJECTS.items()}
    for _, rows in first.table.groupby(["scene", "round"]):
        again = repeat_round(rows, models, settings)
        assert again.drop(columns="score").equals(rows.reset_index(drop=True).drop(columns="score"))


def test_grasps_are_kept_to_the_last_bit(first):
    row = first.table.iloc[0].to_dict()
    grasp = read_grasp(row)
    assert grasp is not None
    assert grasp.width == row["width"]
    np.testing.assert_array_equal(grasp.pose[3], [0, 0, 0, 1])
    np.testing.assert_array_equal(grasp.pose[:3, :3], np.diag([1.0, -1, -1]))


def test_rounds_do_not_depend_on_the_order_of_the_objects():
    settings = ClutterParameters(seed=0, gripper=GRIPPERS["panda"], clutter=Clutter())
    assert rounds_of(list("abcdef"), settings) == rounds_of(list("fdebca"), settings)


def test_an_object_that_cannot_be_simulated_is_left_out(caplog):
    flat = trimesh.Trimesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    objects = {"box": OBJECTS["box0"], "flat": flat}
    table = egad.run_benchmark("random", objects, scenes=["single"], **FEW).table
    assert set(table["objects"]) == {"box"}
    assert "flat is left out" in caplog.text


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"gripper": "hand"}, "hand"),
        ({"scenes": ["heap"]}, "scenes"),
        ({"noise": ["loud"]}, "noise"),
        ({"scenes": []}, "scenes"),
        ({"rounds": 0}, "rounds"),
        ({"per_scene": 0}, "objects"),
        ({"engine": "ode"}, "ode"),
        ({"rule": "big"}, "big"),
        ({"scale": (0.9, 0.8)}, "scale"),
    ],
)
def test_what_is_not_allowed_is_named(changes, text):
    with pytest.raises(UserError, match=text):
        egad.run_benchmark("random", OBJECTS, **({**FEW, **changes}))


@pytest.mark.parametrize("detect", ["graspnet", 7])
def test_what_is_no_detector_is_named(detect):
    with pytest.raises(UserError, match="detector"):
        egad.run_benchmark(detect, OBJECTS, **FEW)


def test_labels_and_antipodal_points_succeed_with_boxes():
    for name in ("labels", "antipodal-cloud"):
        found = egad.run_benchmark(name, OBJECTS, **{**FEW, "scenes": ["packed"]})
        assert found.rates()[0].success.value > 0.7
