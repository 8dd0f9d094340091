"""The attempts that README.md compares in two engines."""

import math
import runpy
from pathlib import Path

import numpy as np
import pytest
import trimesh

import egad
from egad.detectors import Grasp
from egad.geometry import mass_properties
from egad.sim.model import model_of

BAR = trimesh.creation.box((0.03, 0.12, 0.03))


def beside_every_other_bar(view, gripper, rng):
    """Across the middle of the bar, or beside it where there is nothing."""
    points = view.points()[view.heights() > 0.01]
    _, axes = np.linalg.eigh(np.cov(points[:, :2].T))
    x, y = axes[:, 0]
    middle = points[:, :2].mean(axis=0) + rng.integers(2) * 0.1 * axes[:, 0]
    return [Grasp((*middle, 0.015), math.atan2(y, x), gripper.opening, 0.01, 1.0)]


def test_clear_grasps_end_alike_in_both_engines():
    """Deep grasps of a bar hold, and those beside it miss, with and without friction anchors."""
    pytest.importorskip("pybullet")
    table = egad.run_trials(
        beside_every_other_bar, {"bar": BAR}, "panda", attempts=6, seed=1, engine="pybullet"
    ).table
    assert set(table["outcome"]) == {"success", "missed"}
    program = runpy.run_path(str(Path(__file__).with_name("engines.py")))
    model = model_of(BAR, [BAR], mass_properties(BAR, 500.0), 0.0)
    names = program["carried_out"].__globals__
    names.update(model_in=lambda *_: model, rows_by_id=lambda _: {"bar": {}})
    found = program["carried_out"](("bar", table), Path(), "panda")
    for name in ("pybullet", "mujoco", program["ANCHORLESS"]):
        assert found[name].tolist() == table["outcome"].tolist()
