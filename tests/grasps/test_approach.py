import numpy as np
import pytest
import trimesh

from egad.errors import RejectedError
from egad.geometry.rays import RayCaster
from egad.grasps import ContactPairs
from egad.grasps.approach import best_approaches, first_approaches
from egad.grasps.collision import blocked_turns, box_meets_triangle
from egad.grippers import BoxBody, Gripper, Part

HAND = Gripper(
    opening=0.06,
    finger_length=0.05,
    finger_width=0.02,
    finger_thickness=0.01,
    palm=(0.1, 0.06, 0.04),
)


def slow_overlap(triangle, low, high):
    """Cut the triangle by the six planes of the box: is anything left?"""
    polygon = list(triangle)
    for axis in range(3):
        for sign, limit in ((1, high[axis]), (-1, -low[axis])):
            height = [sign * p[axis] - limit for p in polygon]
            kept = []
            for i, p in enumerate(polygon):
                before = polygon[i - 1]
                if height[i] * height[i - 1] < 0:
                    part = height[i - 1] / (height[i - 1] - height[i])
                    kept.append(before + part * (p - before))
                if height[i] <= 0:
                    kept.append(p)
            polygon = kept
    return len(polygon) > 0


def collision_free(mesh, grasps, gripper=HAND, palm=None, retreat=0.1):
    found = best_approaches(RayCaster(mesh), grasps, BoxBody(gripper, palm), way=retreat)
    return found.directions, found.free


def across_x(*centers):
    """Grasps along x of something 40 mm wide."""
    centers = np.array(centers, dtype=float)
    axis = np.array([1.0, 0, 0])
    points = np.stack([centers - 0.02 * axis, centers + 0.02 * axis], axis=1)
    normals = np.tile([-axis, axis], (len(centers), 1, 1))
    return ContactPairs(points, normals, np.tile(axis, (len(centers), 1)))


def test_box_against_triangle_equals_clipping():
    rng = np.random.default_rng(0)
    low, high = np.array([-0.5, -1.0, -0.2]), np.array([0.7, 0.3, 1.5])
    sizes = rng.choice([0.1, 1, 10], (3000, 1, 1))
    triangles = rng.normal(0, 1.2, (3000, 1, 3)) + rng.normal(size=(3000, 3, 3)) * sizes
    expected = [slow_overlap(each, low, high) for each in triangles]
    found = [box_meets_triangle(each, np.stack([low, high])) for each in triangles]
    assert found == expected
    assert 0.1 < np.mean(found) < 0.9


def test_turned_bodies_equal_clipping():
    rng = np.random.default_rng(1)
    triangles = rng.normal(size=(40, 1, 3)) + 0.3 * rng.normal(size=(40, 3, 3))
    low = rng.normal(0, 0.5, (2, 3))
    body = np.stack([low, low + rng.uniform(0.1, 0.5, (2, 3))], axis=1)
    frames = np.linalg.qr(rng.normal(size=(30, 3, 3)))[0]
    frames *= np.linalg.det(frames)[:, None, None]
    origins = rng.normal(0, 0.5, (30, 3))
    turns = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    hand = [Part(box, np.empty((0, 4)), box.mean(axis=0)) for box in body]
    found = blocked_turns(triangles, hand, origins, frames, turns)
    for n in range(30):
        for k, turn in enumerate(turns):
            x, y, z = frames[n]
            axes = np.array(
                [x, np.cos(turn) * y + np.sin(turn) * z, np.cos(turn) * z - np.sin(turn) * y]
            )
            local = (triangles - origins[n]) @ axes.T
            expected = any(slow_overlap(t, *b) for t in local for b in body)
            assert found[n, k] == expected
    assert 0.1 < found.mean() < 0.9


def test_a_small_object_is_free_from_above():
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.02)
    approach, free = collision_free(ball, across_x([0, 0, 0]))
    assert free.all()
    np.testing.assert_allclose(approach, [[0, 0, -1]], atol=1e-12)


def test_a_finger_that_stands_in_the_object_is_not_free():
    slab = trimesh.creation.box([0.08, 0.3, 0.3])
    _, free = collision_free(slab, across_x([0, 0, 0]))
    assert not free.any()


def test_a_palm_that_the_fingers_cannot_clear_is_not_free():
    # the palm's face is 40 mm from the contacts
    for reach, expected in ((0.035, True), (0.045, False)):
        bar = trimesh.creation.cylinder(reach, 0.04, sections=64)
        bar.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
        _, free = collision_free(bar, across_x([0, 0, 0]))
        assert free[0] == expected


def test_the_approach_keeps_away_from_a_wall():
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.015)
    wall = trimesh.creation.box([0.5, 0.5, 0.01]).apply_translation([0, 0, 0.05])
    both = trimesh.util.concatenate([ball, wall])
    approach, free = collision_free(both, across_x([0, 0, 0]))
    assert free[0]
    # from below, away from the wall, not past it
    np.testing.assert_allclose(approach, [[0, 0, 1]], atol=1e-12)


def test_an_obstacle_on_the_way_in_counts():
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.015)
    shell = trimesh.creation.icosphere(subdivisions=3, radius=0.16)
    hollow = trimesh.creation.icosphere(subdivisions=3, radius=0.15)
    hollow.invert()
    both = trimesh.util.concatenate([ball, shell, hollow])
    assert collision_free(both, across_x([0, 0, 0]), retreat=0.0)[1][0]
    found = best_approaches(RayCaster(both), across_x([0, 0, 0]), BoxBody(HAND), way=0.1)
    assert found.fits[0]
    assert not found.free[0]
    assert (found.angles_fit[0], found.angles_collision_free[0]) == (16, 0)


def test_approach_is_a_unit_vector_at_right_angles_to_the_axis():
    rng = np.random.default_rng(2)
    axes = rng.normal(size=(20, 3))
    axes[0] = [0, 0, -1]
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    points = np.stack([-0.02 * axes, 0.02 * axes], axis=1)
    ball = trimesh.creation.box([0.03, 0.03, 0.03]).apply_translation([0, 0.01, 0.01])
    found = collision_free(ball, ContactPairs(points, points, axes), HAND)[0]
    for approach in (first_approaches(axes), found):
        np.testing.assert_allclose(np.linalg.norm(approach, axis=1), 1)
        np.testing.assert_allclose(np.einsum("nk,nk->n", approach, axes), 0, atol=1e-12)
    # as near to straight down as the axis allows
    assert (first_approaches(axes)[1:, 2] < 0).all()


def test_a_hand_all_inside_the_object_is_not_free():
    """No part of it touches the surface."""
    block = trimesh.creation.box([2, 2, 2])
    found = best_approaches(RayCaster(block), across_x([0, 0, 0]), BoxBody(HAND))
    assert not found.fits[0]
    assert (found.angles_fit[0], found.angles_collision_free[0]) == (0, 0)


def test_a_box_as_a_mesh_is_the_palm_box():
    x, y, z = HAND.palm
    palm = trimesh.creation.box([x, y, z]).apply_translation([0, 0, -z / 2])
    rng = np.random.default_rng(4)
    axes = rng.normal(size=(60, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    centers = rng.normal(0, 0.02, (60, 1, 3))
    grasps = ContactPairs(centers + axes[:, None] * [[[-0.02], [0.02]]], np.zeros((60, 2, 3)), axes)
    parts_of = [
        trimesh.creation.icosphere(subdivisions=2, radius=0.01).apply_translation(place)
        for place in rng.normal(0, 0.05, (6, 3))
    ]
    mesh = trimesh.util.concatenate(parts_of)
    expected = best_approaches(RayCaster(mesh), grasps, BoxBody(HAND))
    found = best_approaches(RayCaster(mesh), grasps, BoxBody(HAND, palm))
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert 0.1 < expected.fits.mean() < 0.95


def test_the_pieces_of_a_mesh_count_with_their_hulls():
    """Two posts beside a gap where a palm box would be."""
    post = trimesh.creation.cylinder(0.01, 0.04, sections=32)
    posts = [post.copy().apply_translation([side, 0, -0.02]) for side in (-0.04, 0.04)]
    palm = trimesh.util.concatenate(posts)
    bar = trimesh.creation.cylinder(0.045, 0.04, sections=64)
    bar.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
    grasp = across_x([0, 0, 0])
    assert not collision_free(bar, grasp)[1][0]
    assert collision_free(bar, grasp, palm=palm)[1][0]


def test_a_flat_palm_is_rejected():
    flat = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    with pytest.raises(RejectedError, match="flat"):
        BoxBody(HAND, flat)
