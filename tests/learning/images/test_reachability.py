"""Which grasps a hand can reach from above, tried by hand."""

import numpy as np
import pytest
import trimesh

from egad.geometry.rays import RayCaster
from egad.grasps.collision import MIN_DEPTH, TABLE_CLEARANCE
from egad.grippers import BoxBody
from egad.learning.images.reachability import is_reachable

WAY = 0.1


def lying(mesh, turn=None):
    """The mesh turned, then put on the table."""
    matrix = np.eye(4) if turn is None else turn.copy()
    heights = mesh.vertices @ matrix[2, :3]
    matrix[2, 3] = -heights.min()
    return matrix


def reached(mesh, place, hand, width, *, center=(0, 0, 0), axis=(1.0, 0, 0)):
    """Whether a grasp, given in the frame of a mesh, can be reached where the mesh is."""
    scene = RayCaster(mesh.copy().apply_transform(place))
    centers = np.array([center]) @ place[:3, :3].T + place[:3, 3]
    axes = np.array([axis]) @ place[:3, :3].T
    (found,) = is_reachable(scene, centers, axes, np.array([width]), hand, way=WAY)
    return bool(found)


@pytest.fixture
def slim(hand):
    """A hand whose palm is a stick: what is over a finger meets that finger alone."""
    palm = trimesh.creation.box((0.01, 0.01, 0.06))
    palm.apply_translation((0, 0, -0.03))
    return BoxBody(hand.gripper, palm)


def test_a_block_is_grasped_across_its_sides(block, hand):
    assert reached(block, lying(block), hand, 0.03, center=(0, 0.01, 0.005))
    on_its_side = trimesh.transformations.rotation_matrix(np.pi / 2, (0, 1, 0))
    assert reached(block, lying(block, on_its_side), hand, 0.04, axis=(0, 0, 1.0))


def test_a_neighbor_within_the_room_of_a_finger_is_in_the_way(block, hand):
    """A wall beside the block: free beyond the finger's outer face, not at it."""
    outer = 0.015 + 0.008 + hand.gripper.finger_thickness
    for gap, expected in ((-0.001, False), (0.001, True)):
        wall = trimesh.creation.box((0.01, 0.06, 0.04))
        wall.apply_translation((outer + gap + 0.005, 0, 0))
        both = trimesh.util.concatenate([block, wall])
        assert reached(both, lying(block), hand, 0.03) is expected


def test_the_palm_meets_what_is_higher_than_the_fingers_are_long(block, hand):
    length = hand.gripper.finger_length
    base = hand.gripper.finger_width / 2 - length
    for top, expected in ((-base - 0.001, True), (-base + 0.001, False)):
        tower = trimesh.creation.box((0.01, 0.01, 0.01))
        tower.apply_translation((0, 0.025, top - 0.005))
        both = trimesh.util.concatenate([block, tower])
        assert reached(both, lying(block), hand, 0.03) is expected


@pytest.mark.parametrize(("x", "height"), [(-0.028, 0), (0.028, 0), (0, 0.06)])
def test_what_hangs_over_a_finger_or_the_palm_blocks_its_way_in(block, slim, x, height):
    """It is far above the hand at its place, and in the way if it is lower than the way is long."""
    top = slim.gripper.finger_length - slim.gripper.finger_width / 2 + height
    for gap, expected in ((-0.001, False), (0.001, True)):
        roof = trimesh.creation.box((0.004, 0.06, 0.01))
        roof.apply_translation((x, 0, top + WAY + gap + 0.005))
        both = trimesh.util.concatenate([block, roof])
        assert reached(both, lying(block), slim, 0.03) is expected


@pytest.mark.parametrize("side", [-1, 1])
def test_a_finger_inside_a_thick_block_collides_though_it_meets_no_surface(block, slim, side):
    """A tower beside the block has the whole finger inside it, or leaves the finger out."""
    for near, expected in ((0.018, False), (0.034, True)):
        tower = trimesh.creation.box((0.1, 0.1, 0.6))
        tower.apply_translation((side * (near + 0.05), 0, 0.28))
        both = trimesh.util.concatenate([block, tower])
        assert reached(both, lying(block), slim, 0.03) is expected


def test_a_plate_is_grasped_as_low_as_the_table_allows(hand):
    """The contacts are at half its height; the tips stay above the table and bite below them."""
    for height in (TABLE_CLEARANCE + MIN_DEPTH - 5e-4, TABLE_CLEARANCE + MIN_DEPTH + 5e-4):
        plate = trimesh.creation.box((0.03, 0.06, 2 * height))
        assert reached(plate, lying(plate), hand, 0.03) is (height > TABLE_CLEARANCE + MIN_DEPTH)


@pytest.mark.parametrize("degrees", [-30, 30])
def test_a_tilted_hand_goes_back_along_its_approach_until_it_clears_the_table(hand, degrees):
    """Then its lower finger ends 3 mm over the table; free if it ends 3 mm beyond the contacts."""
    angle = np.radians(degrees)
    bead = trimesh.creation.icosphere(subdivisions=2, radius=0.001)
    outer = 0.001 + 0.008 + hand.gripper.finger_thickness
    least = TABLE_CLEARANCE + np.sin(abs(angle)) * outer + np.cos(angle) * MIN_DEPTH
    for more, expected in ((-2e-4, False), (2e-4, True)):
        place = trimesh.transformations.rotation_matrix(angle, (0, 1, 0))
        place[2, 3] = least + more
        assert reached(bead, place, hand, 0.002) is expected
