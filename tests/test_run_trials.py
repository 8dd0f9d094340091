"""Simulated trials from Python: detectors that must succeed or fail, and wrong arguments."""

import math

import numpy as np
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


@pytest.mark.parametrize(("detector", "outcome"), [(broken, "error"), (blind, "no_grasp")])
def test_what_a_detector_does_wrong_is_the_outcome(good, detector, outcome):
    trials = egad.run_trials(detector, {"bar": BAR}, "panda", attempts=2, seed=2)
    assert trials.table["outcome"].tolist() == [outcome] * 2
    found = good.compare(trials)
    assert (found.attempts, found.difference) == (2, 1.0)


def test_an_object_that_is_no_solid_has_failed_attempts():
    sheet = trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0.01]], [[0, 1, 2]])
    trials = egad.run_trials("random", {"sheet": sheet}, "panda", attempts=2, rule="none")
    assert trials.table["outcome"].tolist() == ["failed", "failed"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"detect": "antipodal"},
            "'antipodal' is not known; did you mean antipodal-depth",
        ),
        ({"objects": {}}, "there are no objects"),
        ({"gripper": "pandas"}, "gripper 'pandas' is not known; did you mean panda"),
        ({"attempts": 0}, "attempts is 0"),
        ({"rule": "best"}, "rule 'best' is not known; .*none"),
        ({"reset": "never"}, "reset is 'never'"),
    ],
)
def test_wrong_arguments_are_told(change, message):
    usual = {"detect": "random", "objects": {"bar": BAR}, "gripper": "panda", "attempts": 1}
    with pytest.raises(UserError, match=message):
        egad.run_trials(**(usual | change))
