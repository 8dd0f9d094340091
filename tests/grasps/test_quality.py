from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from egad.grasps.quality import ferrari_canny, quality_bound

REFERENCE = np.load(Path(__file__).parents[1] / "data" / "ferrari_canny.npz")


def random_grasps(count, largest_angle, seed=0, least_width=0.0):
    """Contacts around a random axis with normals up to some angle away from it."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=(count, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    normals = np.empty((count, 2, 3))
    for c, sign in enumerate((-1, 1)):
        side = np.cross(axis, rng.normal(size=(count, 3)))
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        angle = rng.uniform(0, largest_angle, (count, 1))
        normals[:, c] = sign * np.cos(angle) * axis + np.sin(angle) * side
    center = rng.normal(0, 0.03, (count, 3))
    half = rng.uniform(least_width / 2, 0.04, (count, 1)) * axis
    return np.stack([center - half, center + half], axis=1), normals, axis


def slow_quality(points, normals, axis, com, friction, scaling, radius, faces):
    """One grasp, edge by edge, with Qhull."""
    columns = []
    for p, n, closing in ((points[0], -normals[0], axis), (points[1], -normals[1], -axis)):
        pressure = closing @ n
        if np.linalg.norm(closing - pressure * n) > friction * pressure:
            return 0.0
        tangent = np.array([1.0, 0, 0]) - n[0] * n
        tangent /= np.linalg.norm(tangent)
        for j in range(faces):
            turn = Rotation.from_rotvec(2 * np.pi * j / faces * n)
            force = pressure * (n + friction * turn.apply(tangent))
            columns.append([*force, *(scaling * np.cross(p - com, force))])
        torsion = np.pi * radius**2 * friction * scaling * pressure * n
        columns += [[0, 0, 0, *torsion], [0, 0, 0, *-torsion]]
    return max(0.0, -ConvexHull(columns).equations[:, -1].max())


def closed_form(points, normals, axis, com, scaling=100.0):
    """Torsion about the line of contacts is an upper bound of the quality."""
    cosine = np.abs(np.einsum("nck,nk->nc", normals, axis)).max(axis=1)
    distance = np.linalg.norm(np.cross(points[:, 0] - com, axis), axis=1)
    return np.pi * 0.005**2 * 0.5 * scaling * cosine**2 / np.hypot(1, scaling * distance)


@pytest.mark.parametrize(
    ("count", "friction", "scaling", "radius", "faces"),
    [(2000, 0.5, 100, 0.005, 8), (300, 0.8, 1000, 0.01, 8), (200, 0.3, 100, 0.005, 3)],
)
def test_equals_a_slow_twin(count, friction, scaling, radius, faces):
    points, normals, axis = random_grasps(count, 1.3 * np.arctan(friction))
    com = np.array([0.01, -0.02, 0.005])
    setup = (friction, scaling, radius, faces)
    expected = [
        slow_quality(p, n, a, com, *setup) for p, n, a in zip(points, normals, axis, strict=True)
    ]
    quality = ferrari_canny(
        points,
        normals,
        axis,
        com,
        friction=friction,
        torque_scaling=scaling,
        finger_radius=radius,
        cone_faces=faces,
    )
    np.testing.assert_allclose(quality, expected, atol=1e-9)
    assert 0.3 < (quality > 0).mean() < 0.9


def test_the_bound_is_the_torsion_about_the_line_of_contacts():
    grasps = random_grasps(3000, 0.6)
    com = np.array([0.01, -0.02, 0.005])
    bound = quality_bound(*grasps, com)
    quality = ferrari_canny(*grasps, com)
    assert (quality <= bound).all()
    held = bound > 0
    assert (quality[~held] == 0).all()
    assert 0.3 < held.mean() < 0.9
    assert bound[held] == pytest.approx(closed_form(*grasps, com)[held], rel=1e-6)
    other = {"friction": 0.3, "torque_scaling": 500.0, "finger_radius": 0.01}
    assert (ferrari_canny(*grasps, com, **other) <= quality_bound(*grasps, com, **other)).all()


def test_below_a_floor_an_upper_bound_is_enough():
    grasps = random_grasps(2000, 0.6)
    com = np.array([0.01, -0.02, 0.005])
    exact = ferrari_canny(*grasps, com)
    floor = np.quantile(exact[exact > 0], 0.6)
    found = ferrari_canny(*grasps, com, floor=floor)
    np.testing.assert_array_equal(found[exact >= floor], exact[exact >= floor])
    below = exact < floor
    assert (found[below] < floor).all()
    assert (found[below] >= exact[below] - 1e-12).all()
    assert (found[below] > exact[below]).any()


def test_agrees_with_dex_net():
    names = ("points", "normals", "axis", "com")
    quality = ferrari_canny(*(REFERENCE[name] for name in names))
    both = (quality > 0) & (REFERENCE["quality"] > 0)
    difference = np.abs(quality - REFERENCE["quality"])[both]
    assert both.sum() > 120
    assert difference.max() <= 2e-4
    assert np.median(difference) <= 1e-5


@pytest.mark.parametrize(("part", "holds"), [(0.95, True), (1.001, False)])
def test_contacts_slip_beyond_the_friction_angle(part, holds):
    points, normals, axis = random_grasps(1, 0)
    hinge = np.cross(axis[0], [0, 0, 1])
    angle = part * np.arctan(0.5)
    tilt = Rotation.from_rotvec(angle * hinge / np.linalg.norm(hinge))
    normals[0, 1] = tilt.apply(normals[0, 1])
    assert (ferrari_canny(points, normals, axis, np.zeros(3))[0] > 0) == holds


def test_normals_that_point_inwards_give_zero():
    points, normals, axis = random_grasps(10, 0.1)
    assert (ferrari_canny(points, -normals, axis, np.zeros(3)) == 0).all()


def test_swapping_the_contacts_changes_nothing():
    points, normals, axis = random_grasps(100, 0.4)
    swapped = ferrari_canny(points[:, ::-1], normals[:, ::-1], -axis, np.zeros(3))
    np.testing.assert_allclose(ferrari_canny(points, normals, axis, np.zeros(3)), swapped)


def test_each_grasp_may_have_its_own_center_of_mass_and_friction():
    points, normals, axis = random_grasps(20, 0.2)
    rng = np.random.default_rng(2)
    coms, frictions = rng.normal(0, 0.01, (20, 3)), rng.uniform(0, 1, 20)
    together = ferrari_canny(points, normals, axis, coms, friction=frictions)
    alone = [
        ferrari_canny(points[[i]], normals[[i]], axis[[i]], coms[i], friction=frictions[i])[0]
        for i in range(20)
    ]
    np.testing.assert_array_equal(together, alone)


def test_no_grasps_and_only_slipping_grasps():
    assert (
        ferrari_canny(np.empty((0, 2, 3)), np.empty((0, 2, 3)), np.empty((0, 3)), [0] * 3).size == 0
    )
    points, normals, axis = random_grasps(3, 0.1)
    assert (ferrari_canny(points, normals, axis, np.zeros(3), friction=0) == 0).all()
    assert (ferrari_canny(points, normals * np.nan, axis, np.zeros(3)) == 0).all()
