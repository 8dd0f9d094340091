"""Hulls for PyBullet, which adds a margin around each of them."""

import io
from types import SimpleNamespace

import pytest
import trimesh

from egad.sim.robot import HullShape, Link
from egad.sim.urdf import hull_files

MARGIN = 0.001


@pytest.mark.parametrize(("thick", "left"), [(0.01, 0.008), (0.003, 0.001), (0.001, 0.0001)])
def test_hulls_shrink_by_the_margin_or_nearly_to_nothing(thick, left):
    plate = trimesh.creation.box((0.03, 0.02, thick)).apply_translation((0.1, 0.0, 0.05))
    robot = SimpleNamespace(links=[Link("finger", shapes=(HullShape(plate.vertices),))])
    (text,) = hull_files(robot, MARGIN).values()
    found = trimesh.load(io.StringIO(text), file_type="obj", process=False)
    margin = (thick - left) / 2
    assert found.extents == pytest.approx([0.03 - 2 * margin, 0.02 - 2 * margin, left], abs=1e-6)
    assert found.bounds.mean(axis=0) == pytest.approx([0.1, 0.0, 0.05], abs=1e-6)
