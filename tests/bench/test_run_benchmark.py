"""Detectors clear tables from Python."""

from contextlib import contextmanager

import numpy as np
import pytest
import trimesh
from PIL import Image

import egad
from egad.bench import (
    Clutter,
    ClutterParameters,
    clearing,
    preparation,
    repeat_round,
    rounds_of,
    scenes,
)
from egad.detectors import DetectorConfig, GraspPoses
from egad.errors import UserError
from egad.grippers import GRIPPERS
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


def test_a_detector_that_cannot_be_started_is_noticed_before_objects_are_made(monkeypatch):
    monkeypatch.setattr("egad.bench.benchmark.prepare_objects", None)  # it is not called
    command = DetectorConfig(command=["/no/such/program"])
    with pytest.raises(UserError, match=r"/no/such/program cannot be started: .*No such file"):
        egad.run_benchmark(command, OBJECTS, **FEW)


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
    again = egad.run_benchmark(at_the_highest_point, OBJECTS, jobs=2, scenes=["packed"], **FEW)
    packed = first.table[first.table["scene"] == "packed"].reset_index(drop=True)
    assert packed.equals(again.table)


@pytest.fixture(scope="module")
def idle():
    """What comes of doing nothing."""
    return egad.run_benchmark(nothing, OBJECTS, **FEW)


def test_all_detectors_meet_the_same_scenes(first, idle):
    other = idle.table
    assert (other["outcome"] == "no_grasp").all()
    mine = first.table[first.table["attempt"] == 0]
    for name in ("scene", "round", "seed", "objects", "n_objects"):
        assert mine[name].tolist() == other[name].tolist()


def test_a_round_is_repeated_from_its_rows_and_its_objects_alone(first):
    """Bit by bit, though the settings of the rounds are not known."""
    settings = ClutterParameters(seed=9, gripper=GRIPPERS["panda"], clutter=Clutter())
    for _, rows in first.table.groupby(["scene", "round"]):
        names = rows["objects"].iloc[0].split()
        models = {name: first._scenes.models[name] for name in names}
        again = repeat_round(rows, models, settings)
        assert again.drop(columns="score").equals(rows.reset_index(drop=True).drop(columns="score"))


def test_an_attempt_without_a_grasp_is_repeated_with_its_outcome():
    def too_wide(_view, gripper, _rng):
        return np.eye(4)[None], np.array([2 * gripper.opening]), np.ones(1)

    found = egad.run_benchmark(too_wide, OBJECTS, **{**FEW, "scenes": ["single"], "rounds": 1})
    assert found.table["outcome"].tolist() == ["too_wide"] * 2
    assert repeat_round(found.table, *found._scenes)["outcome"].tolist() == ["too_wide"] * 2


def test_labels_meet_the_same_scenes_though_an_object_has_no_grasp():
    few = {**FEW, "scenes": ["packed"], "per_scene": 5}
    objects = {**OBJECTS, "cube": trimesh.creation.box([0.1] * 3)}  # too wide for the hand
    tables = [egad.run_benchmark(name, objects, **few).table for name in ("labels", "random")]
    one, other = (table[table["attempt"] == 0].reset_index(drop=True) for table in tables)
    for name in ("objects", "factors", "present"):
        assert one[name].tolist() == other[name].tolist()
    assert one["objects"].str.contains("cube").any()


def test_scenes_without_objects_do_not_end_the_run(monkeypatch):
    monkeypatch.setattr(scenes, "in_workspace", lambda _: False)
    found = egad.run_benchmark("random", OBJECTS, **{**FEW, "scenes": ["single"]})
    assert found.table["outcome"].tolist() == ["failed"] * FEW["rounds"]
    assert found.rates() == []


@pytest.mark.parametrize("name", ["ggcnn2-evolved", "vgn-evolved"])
def test_shipped_networks_lift_boxes(name):
    pytest.importorskip("torch")
    found = egad.run_benchmark(name, OBJECTS, **{**FEW, "scenes": ["single"], "rounds": 8})
    assert found.table["success"].mean() > 0.5


def test_a_round_is_filmed_and_compared(first, idle, tmp_path):
    first.film("single", 1, tmp_path / "film.gif")
    assert Image.open(tmp_path / "film.gif").n_frames > 20
    with pytest.raises(UserError, match="not in the table"):
        first.film("single", 2, tmp_path / "film.gif")
    with pytest.raises(UserError, match="can be filmed"):
        egad.Benchmark(first.table).film("single", 1, tmp_path / "film.gif")
    for found, rates in zip(first.compare(idle), first.rates(), strict=True):
        assert (found.scene, found.rounds) == (rates.scene, rates.rounds)
        assert found.cleared == pytest.approx(rates.cleared.value)  # the other clears nothing
    assert 0 < first.planning_time < 60


def test_rounds_do_not_depend_on_the_order_of_the_objects():
    settings = ClutterParameters(seed=0, gripper=GRIPPERS["panda"], clutter=Clutter())
    assert rounds_of(list("abcdef"), settings) == rounds_of(list("fdebca"), settings)


def test_an_object_that_cannot_be_simulated_is_left_out(caplog):
    flat = trimesh.Trimesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    objects = {"box": OBJECTS["box0"], "flat": flat}
    few = FEW | {"rounds": 4}
    table = egad.run_benchmark("random", objects, scenes=["single"], **few).table
    assert set(table["objects"]) == {"box"}
    assert "flat is left out" in caplog.text
    alone = egad.run_benchmark("random", {"box": OBJECTS["box0"]}, scenes=["single"], **few).table
    assert table.equals(alone)


def test_of_the_evaluation_set_only_objects_of_the_rounds_are_made(monkeypatch):
    made = []
    simulated = preparation.simulated
    monkeypatch.setattr(
        preparation,
        "simulated",
        lambda target, *rest: made.append(target.id) or simulated(target, *rest),
    )
    few = FEW | {"rounds": 1, "scenes": ["single"], "rule": "paper"}
    table = egad.run_benchmark("random", egad.load("evaluation-set"), **few).table
    assert made == table["objects"].unique().tolist()


def test_more_rounds_begin_with_the_same_scenes_though_an_object_cannot_be_used():
    broken = trimesh.creation.box((0.03, 0.03, 0.03))
    broken.update_faces(broken.face_normals[:, 2] < 0.5)  # a box without a lid
    few = FEW | {"scenes": ["single"]}
    objects = {"broken": broken, **OBJECTS}
    one, more = (
        egad.run_benchmark("random", objects, **few | {"rounds": rounds}).table for rounds in (1, 6)
    )
    first = more[more["round"] == 0]
    assert one["objects"].tolist() == first["objects"].tolist()
    assert set(more["objects"]) <= set(OBJECTS)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"gripper": "hand"}, "hand"),
        ({"scenes": ["heap"]}, "scenes"),
        ({"rounds": 0}, "rounds"),
        ({"engine": "ode"}, "ode"),
        ({"protocol": {"contact": "bounce"}}, r"protocol\[contact\] is 'bounce'"),
    ],
)
def test_what_is_not_allowed_is_named(changes, text):
    with pytest.raises(UserError, match=text):
        egad.run_benchmark("random", OBJECTS, **({**FEW, **changes}))


@pytest.mark.parametrize(
    ("changes", "name", "noise"),
    [
        ({"protocol": "edgegrasp"}, "edgegrasp", {"points"}),
        ({"protocol": "giga", "noise": ["none"]}, "giga", {"none"}),
        ({"protocol": "vgn", "scale": (0.5, 0.6)}, "custom", {"none"}),
        ({"protocol": {"failures": 1}}, "custom", {"none", "stereo"}),
    ],
)
def test_the_table_names_its_protocol(changes, name, noise):
    few = {"rounds": 1, "per_scene": 2, "scenes": ["packed"]}
    result = egad.run_benchmark(nothing, OBJECTS, **few | changes)
    assert set(result.table["protocol"]) == {name}
    assert set(result.table["noise"]) == noise
    assert f"protocol {name}" in repr(result)
    factors = [float(each) for text in result.table["factors"] for each in text.split()]
    if "scale" in changes:
        assert all(0.5 <= each <= 0.6 for each in factors)
    assert (len(result.table) == 3) == (name == "edgegrasp")  # its skips


def test_vgn_proposes_what_the_threshold_of_the_protocol_asks_for(monkeypatch):
    asked = []

    @contextmanager
    def opened(config, _):
        asked.append(config.threshold)
        yield None

    monkeypatch.setattr(clearing, "opened", opened)
    for protocol, own in (("egad", None), ("giga", None), ("vgn", None), ("giga", 0.7)):
        clutter = Clutter(protocol=protocol)
        settings = ClutterParameters(seed=0, gripper=GRIPPERS["panda"], clutter=clutter)
        clearing.check_detector(DetectorConfig(detector="vgn", threshold=own), settings)
    assert asked == [None, 0.5, 0.9, 0.7]
    with pytest.raises(ValueError, match="random takes no `threshold`: only vgn does"):
        DetectorConfig(detector="random", threshold=0.5)
