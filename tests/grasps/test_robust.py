import numpy as np
import pytest
import trimesh

from egad.geometry.rays import RayCaster
from egad.grasps import ContactPairs, Quality, Robust, Sampling, Spread, sample_contacts
from egad.grasps.quality import ferrari_canny
from egad.grasps.robust import close_fingers, robust_ferrari_canny

CALM = Spread(*[0.0] * len(Spread._fields))
CEILING = np.pi * 0.005**2 * 0.5 * 1000


def rate(mesh, grasps, opening=0.05, com=(0, 0, 0), seed=0, samples=25, **sigmas):
    return robust_ferrari_canny(
        RayCaster(mesh),
        grasps,
        np.array(com, dtype=float),
        opening,
        quality=Quality(),
        robust=Robust(samples=samples),
        spread=CALM._replace(**sigmas),
        rng=np.random.default_rng(seed),
    )


def pinch(width, count=1):
    """The same grasp across x, through the origin, several times."""
    points = np.array([[-width / 2, 0, 0], [width / 2, 0, 0]])
    normals = np.array([[-1.0, 0, 0], [1.0, 0, 0]])
    each = (points, normals, np.array([1.0, 0, 0]))
    return ContactPairs(*(np.repeat(value[None], count, axis=0) for value in each))


def test_without_disturbance_it_is_the_plain_quality():
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=0.02)
    grasps, _ = sample_contacts(RayCaster(mesh), 0.05, 50, Sampling(), np.random.default_rng(0))
    plain = ferrari_canny(
        grasps.points, grasps.normals, grasps.axes, np.zeros(3), torque_scaling=1000
    )
    mean, deviation, held = rate(mesh, grasps, samples=3)
    np.testing.assert_allclose(mean, plain, rtol=1e-9)
    np.testing.assert_allclose(deviation, 0, atol=1e-12)
    np.testing.assert_array_equal(held, plain > 0)
    assert 0.3 < held.mean() < 1


@pytest.mark.parametrize("moved", ["object_translation_sigma", "grasp_translation_sigma"])
def test_a_finger_that_starts_inside_the_object_misses(moved):
    # 5 mm of room either side: one standard deviation
    mesh = trimesh.creation.box([0.04, 0.5, 0.5])
    _, _, held = rate(mesh, pinch(0.04), samples=4000, **{moved: 0.005})
    assert held[0] == pytest.approx(0.6827, abs=0.025)


@pytest.mark.parametrize("turned", ["object_rotation_sigma", "grasp_rotation_sigma"])
def test_a_turned_object_slips_beyond_the_friction_angle(turned):
    mesh = trimesh.creation.box([0.04, 2, 2])
    _, _, held = rate(mesh, pinch(0.04), opening=0.2, samples=4000, **{turned: 0.3})
    # two of three components of a normal rotation vector tilt the axis; the linearised cone
    # lies between the round one and the one that touches its faces
    inner, outer = (
        1 - np.exp(-(np.arctan(friction) ** 2) / (2 * 0.3**2))
        for friction in (0.5 * np.cos(np.pi / 8), 0.5)
    )
    assert inner - 0.02 < held[0] < outer + 0.02


def test_the_object_turns_about_its_center_of_mass():
    # far from the center of mass a small turn carries the object out of the fingers
    mesh = trimesh.creation.box([0.04, 2, 2])
    near = rate(mesh, pinch(0.04), samples=500, object_rotation_sigma=0.01)[2]
    far = rate(mesh, pinch(0.04), com=[0, 1, 0], samples=4000, object_rotation_sigma=0.01)[2]
    assert near == 1
    assert far[0] == pytest.approx(0.383, abs=0.03)  # a normal variable within half its deviation


def test_thin_objects_are_pushed_along_not_missed():
    mesh = trimesh.creation.box([0.001, 0.5, 0.5])
    _, _, held = rate(mesh, pinch(0.001), samples=200, object_translation_sigma=0.005)
    assert held == 1


def test_disturbed_center_of_mass_follows_the_closed_form():
    mesh = trimesh.creation.box([0.04, 0.5, 0.5])
    mean, deviation, _ = rate(mesh, pinch(0.04), samples=4000, com_sigma=0.01)
    radius = np.abs(np.random.default_rng(1).normal(0, 0.01, (2, 200_000)))
    expected = CEILING / np.hypot(1, 1000 * np.hypot(*radius))
    assert mean[0] == pytest.approx(expected.mean(), rel=0.05)
    assert deviation[0] == pytest.approx(expected.std(), rel=0.1)


def test_friction_is_never_negative():
    mesh = trimesh.creation.box([0.04, 0.5, 0.5])
    mean, _, held = rate(mesh, pinch(0.04), samples=4000, friction_sigma=0.5)
    assert held[0] == pytest.approx(0.8413, abs=0.02)
    # mean of max(N(0.5, 0.5), 0): 0.5 * (Phi(1) + phi(1))
    assert mean[0] == pytest.approx(CEILING * (0.8413 + 0.2420), rel=0.03)


def test_copies_of_a_grasp_differ_and_are_reproducible():
    mesh = trimesh.creation.box([0.04, 0.5, 0.5])
    first = rate(mesh, pinch(0.04, 2), com_sigma=0.01)
    again = rate(mesh, pinch(0.04, 2), com_sigma=0.01)
    np.testing.assert_array_equal(first, again)
    assert first[0][0] != first[0][1]


def test_fingers_close_on_what_is_there():
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=0.02)
    centers = np.array([[0.003, 0.01, 0], [0, 0.03, 0], [0.01, 0, 0]])
    contacts, touching = close_fingers(RayCaster(mesh), centers, np.tile([1.0, 0, 0], (3, 1)), 0.05)
    assert touching.tolist() == [True, False, False]  # a miss, and a finger inside
    side = np.sqrt(0.02**2 - 0.01**2)
    expected = [[-side, 0.01, 0], [side, 0.01, 0]]
    np.testing.assert_allclose(contacts.points[0], expected, atol=2e-4)
    assert contacts.normals[0, 0, 0] < 0 < contacts.normals[0, 1, 0]
