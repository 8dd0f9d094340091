import numpy as np
import pytest
import trimesh

from egad.geometry.mass import mass_properties


def test_a_block_has_the_textbook_values():
    block = trimesh.creation.box((0.1, 0.2, 0.3)).apply_translation([1.0, -2.0, 3.0])
    found = mass_properties(block, 500.0)
    assert found.volume == pytest.approx(0.006)
    assert found.area == pytest.approx(0.22)
    assert found.mass == pytest.approx(3.0)
    assert np.allclose(found.com, [1, -2, 3])
    a, b, c = 0.01, 0.04, 0.09
    assert np.allclose(found.inertia, np.diag([b + c, a + c, a + b]) * 3 / 12)


def test_inertia_turns_with_the_body_and_does_not_depend_on_its_place():
    cone = trimesh.creation.cone(radius=0.03, height=0.1)
    here = mass_properties(cone, 400.0)
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [0, 0, 0])
    moved = mass_properties(cone.copy().apply_transform(turn).apply_translation([5, 6, 7]), 400.0)
    rotation = turn[:3, :3]
    assert np.allclose(moved.inertia, rotation @ here.inertia @ rotation.T, rtol=1e-9, atol=1e-15)
    assert np.allclose(moved.com, rotation @ here.com + [5, 6, 7])
    assert moved.inertia[0, 1] != pytest.approx(0, abs=1e-9)  # the turned tensor is not diagonal


@pytest.mark.parametrize("size", [1e-4, 1e-2, 1.0])
def test_digits_do_not_depend_on_the_size(size):
    ball = trimesh.creation.icosphere(subdivisions=2)
    unit = mass_properties(ball, 1.0)
    small = mass_properties(ball.copy().apply_scale(size), 1.0)
    assert small.volume == pytest.approx(unit.volume * size**3, rel=1e-12)
    assert small.inertia[0, 0] == pytest.approx(unit.inertia[0, 0] * size**5, rel=1e-9)


def test_random_points_inside_have_the_same_moments():
    ring = trimesh.creation.annulus(0.02, 0.05, 0.03).apply_translation([0.01, 0.02, 0.03])
    points = np.random.default_rng(0).uniform(*ring.bounds, (400_000, 3))
    radius = np.hypot(points[:, 0] - 0.01, points[:, 1] - 0.02)
    inside = points[(radius > 0.02) & (radius < 0.05)]
    found = mass_properties(ring, 1000.0)
    assert np.allclose(found.com, inside.mean(axis=0), atol=2e-4)
    around = ((inside - found.com)[:, :2] ** 2).sum(axis=1).mean() * found.mass
    assert found.inertia[2, 2] == pytest.approx(around, rel=0.02)
