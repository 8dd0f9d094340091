"""Simulated trials from Python: detectors that must succeed or fail, and wrong arguments."""

import math
import threading

import numpy as np
import pandas as pd
import pytest
import trimesh

import egad
from egad.detectors import Grasp
from egad.errors import UserError

BAR = trimesh.creation.box((0.03, 0.12, 0.03))


def across_the_bar(view, gripper, _):
    """Grasps the middle of what stands out of the table, across its longer side."""
    points = view.points()[view.heights() > 0.01]
    _, axes = np.linalg.eigh(np.cov(points[:, :2].T))
    x, y = axes[:, 0]
    center = (*points[:, :2].mean(axis=0), 0.015)
    return [Grasp(center, math.atan2(y, x), gripper.opening, 0.01, 1.0)]


def broken(*_):
    raise ZeroDivisionError


def blind(*_):
    return []


def broken_unless_centered(view, _gripper, _rng):
    points = view.points()[view.heights() > 0.01]
    raise ValueError(f"{len(points)} points")


@pytest.fixture(scope="module")
def good():
    return egad.run_trials(across_the_bar, {"bar": BAR}, "panda", attempts=4, seed=2)


def test_a_good_grasp_of_a_bar_succeeds(good):
    rate = good.success_rate()
    assert (rate.successes, rate.attempts) == (4, 4)
    assert good.by_object().loc["bar"].tolist() == [4, 4]
    assert good.table["lifted"].min() > 0.3


def test_the_same_seed_gives_the_same_attempts(good):
    again = egad.run_trials(across_the_bar, {"bar": BAR}, "panda", attempts=4, seed=2)
    assert again.table.equals(good.table)
    other = egad.run_trials(across_the_bar, {"bar": BAR}, "panda", attempts=4, seed=3)
    assert not other.table["initial_qw"].equals(good.table["initial_qw"])


def test_the_engine_is_mujoco_unless_another_one_is_asked_for(good):
    assert good.table["engine"].unique().tolist() == ["mujoco"]
    assert repr(good).startswith("Trials in mujoco: 100.0 % (")
    pytest.importorskip("pybullet")
    trials = egad.run_trials(across_the_bar, {"bar": BAR}, "panda", attempts=1, engine="pybullet")
    assert trials.table["engine"].tolist() == ["pybullet"]


def test_a_detector_that_asks_for_more_than_a_view_is_told_where_to_go():
    def detect(cloud, _gripper, _rng):
        return cloud

    with pytest.raises(UserError, match=r"cloud.*run_benchmark"):
        egad.run_trials(detect, {"bar": BAR}, "panda", attempts=1)
    for name in ("antipodal-cloud", "vgn-evolved"):
        with pytest.raises(UserError, match=f"{name} asks for more, .*run_benchmark"):
            egad.run_trials(name, {"bar": BAR}, "panda", attempts=1)


@pytest.mark.parametrize(("detector", "outcome"), [(broken, "error"), (blind, "no_grasp")])
def test_what_a_detector_does_wrong_is_the_outcome(good, detector, outcome):
    trials = egad.run_trials(detector, {"bar": BAR}, "panda", attempts=2, seed=2, keep_going=True)
    assert trials.table["outcome"].tolist() == [outcome] * 2
    assert trials.table["failure"].str.contains("ZeroDivisionError").all() == (outcome == "error")
    found = good.compare(trials)
    assert (found.attempts, found.difference) == (2, 1.0)


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_detector_that_only_fails_stops_with_its_traceback(jobs, caplog):
    many = {f"bar{number}": BAR for number in range(8)}
    with pytest.raises(UserError, match=r"all 6 attempts of the first 3 objects") as raised:
        egad.run_trials(broken_unless_centered, many, "panda", attempts=2, jobs=jobs)
    line = broken_unless_centered.__code__.co_firstlineno + 2
    where = f'File "test_run_trials.py", line {line}, in broken_unless_centered'
    assert (caplog.text + str(raised.value)).count(where) == 1
    assert "points" in caplog.text.splitlines()[-1]


def open_box():
    box = trimesh.creation.box((0.1, 0.05, 0.03))
    box.update_faces(np.arange(12) > 1)
    return box


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("rule", ["none", "paper"])
@pytest.mark.parametrize(
    "sheet", [trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0.01]], [[0, 1, 2]]), open_box()]
)
def test_an_object_that_is_no_solid_has_failed_attempts(sheet, rule, caplog):
    trials = egad.run_trials("random", {"sheet": sheet}, "panda", attempts=2, rule=rule)
    assert trials.table["outcome"].tolist() == ["failed", "failed"]
    assert "sheet cannot be simulated: " in caplog.text


def test_processes_give_the_same_table(good):
    """Meshes by name and a dataset, with a detector that cannot be imported and one by its name."""

    def detect(view, gripper, rng):
        return across_the_bar(view, gripper, rng)

    two = {"bar": BAR, "short": BAR.copy().apply_scale(0.8)}
    one, more = (
        egad.run_trials(detect, two, "panda", attempts=2, seed=2, jobs=jobs) for jobs in (1, 2)
    )
    pd.testing.assert_frame_equal(one.table, more.table)
    assert one.table["label"].tolist() == ["bar"] * 2 + ["short"] * 2
    pd.testing.assert_frame_equal(one.table[:2], good.table[:2])
    dataset = egad.load("released").select(["C02_0", "E03_0"])
    one, more = (
        egad.run_trials("antipodal-depth", dataset, "panda", attempts=1, jobs=jobs)
        for jobs in (1, 2)
    )
    pd.testing.assert_frame_equal(one.table, more.table)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"detect": "antipodal"},
            "'antipodal' is not known; did you mean antipodal-depth",
        ),
        ({"objects": {}}, "there are no objects"),
        (
            {"objects": {"bar": "bar.stl"}, "rule": "none"},
            r"a mesh must be a trimesh\.Trimesh, got str",
        ),
        ({"gripper": "pandas"}, "gripper 'pandas' is not known; did you mean panda"),
        ({"engine": "auto"}, "engine 'auto' is not known; .*mujoco, pybullet"),
        ({"errors": "typcal"}, "errors is 'typcal'; allowed: none, typical, or a section with"),
        ({"errors": {"positoning": 0.1}}, "'positoning' is not known; did you mean positioning"),
        ({"errors": {"mass": (1.2, 0.8)}}, "mass must go from a positive low to high"),
        ({"stopping_force": 0}, "stopping_force is 0; allowed: a number, above 0"),
        ({"detect": 3}, "a detector is a function or the name of one, got 3"),
        ({"detect": threading.Lock().acquire, "jobs": 2}, "cannot be sent to another process"),
    ],
)
def test_wrong_arguments_are_told(change, message):
    usual = {"detect": "random", "objects": {"bar": BAR}, "gripper": "panda", "attempts": 1}
    with pytest.raises(UserError, match=message):
        egad.run_trials(**(usual | change))
