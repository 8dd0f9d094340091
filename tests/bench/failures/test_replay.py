"""Attempts that are carried out again end as they did, in both engines and from any direction."""

from functools import cache

import numpy as np
import pandas as pd
import pytest
import trimesh

import egad
from egad.bench.failures import Examination, FailureSearch, film_attempts
from egad.bench.failures.finding import failure_parameters
from egad.bench.failures.replay import repeat_attempts
from egad.detectors import Grasp, GraspPoses
from egad.errors import UserError

PANDA = egad.gripper("panda")


def from_above(_view, gripper, rng):
    """A grasp anywhere around the middle: few hold."""
    x, y = rng.uniform(-0.06, 0.06, size=2)
    return [Grasp((x, y, 0.01), rng.uniform(0, np.pi), gripper.opening, 0.0, 1.0)]


def from_anywhere(cloud, gripper, rng):
    """The same from aside."""
    assert len(cloud)
    pose = np.eye(4)
    pose[:3, :3] = [[0, 0.6, 0.8], [1, 0, 0], [0, 0.8, -0.6]]
    pose[:3, 3] = *rng.uniform(-0.06, 0.06, size=2), 0.02
    return GraspPoses(pose[None], np.array([gripper.opening]), np.ones(1))


def settings_for(approach):
    search = FailureSearch(
        approach=approach,
        confirm=12,
        confidence=0.5,
        choose=4,
        screen=4,
        least_difference=0.1,
        least_reference=0.5,
    )
    return failure_parameters(PANDA, search, seed=4)


@cache
def examined(approach):
    """A box, what became of it, and with which settings."""
    mesh = trimesh.creation.box((0.03, 0.04, 0.05))
    settings = settings_for(approach)
    detect = {"above": from_above, "any": from_anywhere}[approach]
    return mesh, Examination(mesh, "box", detect, settings).run().attempts, settings


def grasped(attempts):
    return attempts[attempts["pose"].map(len) > 0].reset_index(drop=True)


@pytest.mark.parametrize("approach", ["above", "any"])
def test_outcomes_are_those_of_the_table(approach):
    mesh, attempts, settings = examined(approach)
    rows = grasped(attempts)
    assert set(rows["engine"]) == {"mujoco", "pybullet"}
    assert {"choose", "confirm"} <= set(rows["purpose"])
    assert set(rows["who"]) == {"detector", "reference"}
    assert len(set(rows["outcome"])) > 1
    mixed = rows.sample(frac=1, random_state=0)
    assert [str(each) for each in repeat_attempts(mesh, mixed, settings)] == list(mixed["outcome"])


@pytest.mark.parametrize("approach", ["above", "any"])
def test_a_film_shows_a_success_and_another_end_is_refused(approach, monkeypatch):
    mesh, attempts, settings = examined(approach)
    row = grasped(attempts).query("success").tail(1)
    monkeypatch.setattr("egad.sim.film.draw", lambda bodies, *_: bodies[1][0].bounds)
    (frames,) = film_attempts(mesh, row, settings)
    assert frames[0][0, 2] == pytest.approx(0, abs=0.002)
    assert frames[-1][0, 2] > 0.05
    with pytest.raises(UserError, match=r"box, drop \d+ in .*: missed became success"):
        film_attempts(mesh, row.assign(outcome="missed"), settings)


def test_films_are_in_the_order_of_the_table(monkeypatch):
    monkeypatch.setattr("egad.sim.film.draw", lambda bodies, *_: bodies[1][0].bounds)
    mesh, attempts, settings = examined("any")
    rows = grasped(attempts).groupby("engine").head(1).iloc[::-1]
    films = film_attempts(mesh, rows, settings)
    assert not np.array_equal(films[0][-1], films[1][-1])
    for number in range(len(rows)):
        (alone,) = film_attempts(mesh, rows.iloc[[number]], settings)
        assert len(alone) == len(films[number])
        np.testing.assert_array_equal(alone[-1], films[number][-1])


def test_what_was_not_tried_cannot_be_repeated():
    mesh, attempts, settings = examined("above")
    row = pd.DataFrame([attempts.iloc[0].to_dict() | {"pose": []}])
    with pytest.raises(UserError, match="proposed nothing"):
        repeat_attempts(mesh, row, settings)
