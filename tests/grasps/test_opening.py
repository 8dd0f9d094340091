import numpy as np
import pytest
import trimesh

from egad.geometry.rays import RayCaster
from egad.grasps import ContactPairs, Sampling, sample_contacts
from egad.grasps.approach import best_approaches
from egad.grasps.opening import needed_openings
from egad.grippers import BoxBody, Gripper, finger_span

HAND = Gripper(opening=0.06, finger_length=0.05, finger_width=0.02, finger_thickness=0.01)
DOWN = np.array([[0.0, 0.0, -1.0]])


def across_x(width):
    axis = np.array([1.0, 0, 0])
    points = np.array([[-width / 2 * axis, width / 2 * axis]])
    return ContactPairs(points, np.array([[-axis, axis]]), axis[None])


def needed(mesh, width, hand=HAND):
    return needed_openings(RayCaster(mesh), across_x(width), DOWN, BoxBody(hand))[0]


def box(sides, place=(0, 0, 0)):
    return trimesh.creation.box(sides).apply_translation(place)


def test_a_flat_object_needs_its_width():
    assert needed(box([0.03, 0.1, 0.1]), 0.03) == pytest.approx(0.03)


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ((0.02, 0.009, 0), 0.05),  # within the width of the pads: 20 mm
        ((0.02, 0.012, 0), 0.03),  # beside them
        ((0.02, 0, 0.038), 0.05),  # before the palm: the hand comes from above
        ((0.02, 0, -0.009), 0.05),
        ((0.02, 0, -0.012), 0.03),  # beyond the fingertips
        ((-0.02, 0, 0.03), 0.05),  # both fingers open alike
        ((0.0301, 0, 0.0), 0.03),  # behind the finger
    ],
)
def test_what_is_near_the_contacts_counts(place, expected):
    mesh = trimesh.util.concatenate([box([0.03, 0.003, 0.003]), box([0.01, 0.001, 0.001], place)])
    assert needed(mesh, 0.03) == pytest.approx(expected)


def test_a_finger_does_not_stand_in_a_thick_wall():
    """Its surface is nowhere near the finger, 10 mm thick, in the middle of 40 mm."""
    wall = box([0.04, 0.2, 0.2], [0.043, 0, 0])
    mesh = trimesh.util.concatenate([box([0.03, 0.02, 0.02]), wall])
    assert needed(mesh, 0.03) == pytest.approx(2 * 0.063)


def test_a_pad_on_a_slope_needs_more():
    turn = trimesh.transformations.rotation_matrix(np.radians(20), [0, 0, 1])
    slab = box([0.02, 0.2, 0.2]).apply_transform(turn)
    width = 0.02 / np.cos(np.radians(20))
    expected = width + 0.02 * np.tan(np.radians(20))
    assert needed(slab, width) == pytest.approx(expected)


def test_openings_equal_trying_one_after_another():
    """Points all over the object, against fingers that open by steps."""
    mesh = trimesh.creation.torus(0.03, 0.012, major_sections=48, minor_sections=24)
    rng = np.random.default_rng(0)
    grasps, _ = sample_contacts(RayCaster(mesh), HAND.opening, 25, Sampling(), rng)
    best = best_approaches(RayCaster(mesh), grasps, BoxBody(HAND))
    found = needed_openings(RayCaster(mesh), grasps, best.directions, BoxBody(HAND))
    points = trimesh.sample.sample_surface(mesh, 400_000, seed=1)[0]
    base, tip = finger_span(HAND)
    for i, approach in enumerate(best.directions):
        frame = np.array([grasps.axes[i], np.cross(approach, grasps.axes[i]), approach])
        x, y, z = ((points - grasps.centers[i]) @ frame.T).T
        near = np.sort(np.abs(x[(abs(y) < HAND.finger_width / 2) & (base < z) & (z < tip)]))
        half = grasps.widths[i] / 2
        while ((near > half + 1e-4) & (near < half + HAND.finger_thickness - 1e-4)).any():
            half += 5e-5
        assert found[i] == pytest.approx(2 * half, abs=8e-4)
    assert (found >= grasps.widths).all()
    assert (found > grasps.widths + 1e-3).mean() > 0.2
    assert (found[best.fits] <= HAND.opening + 2.1e-4).all()
