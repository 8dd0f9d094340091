"""Grasps of a hand with one moving jaw: what turns, what is in its way, and what it cannot hold."""

import numpy as np
import pytest
import trimesh
from described_hands import jaw_urdf

from egad.geometry import RayCaster
from egad.grasps import ContactPairs
from egad.grasps.approach import best_approaches
from egad.grasps.labels import label_parameters
from egad.grasps.opening import needed_openings
from egad.grasps.quality import ferrari_canny
from egad.grasps.robust import JawFaces, face_normals
from egad.grasps.sampling import Labeller
from egad.grippers import JAW_CLEARANCE, Gripper, ModelBody, hand_body

ACROSS = np.array([1.0, 0.0, 0.0])
DOWN = np.array([[0.0, 0.0, -1.0]])


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> ModelBody:
    path = jaw_urdf(tmp_path_factory.mktemp("hand") / "jaw.urdf")
    found = hand_body(Gripper.from_file(path))
    assert isinstance(found, ModelBody)
    return found


def pair(width: float, way: float = 1.0) -> ContactPairs:
    """Contacts at a plate that stands upright at x = 0; way -1: the fixed jaw on the other side."""
    axis = way * ACROSS
    points = np.array([[-width / 2 * axis, width / 2 * axis]])
    return ContactPairs(points, np.array([[-axis, axis]]), axis[None])


def plate(thickness: float, x: float = 0.0, height: float = 0.04) -> trimesh.Trimesh:
    """An upright plate, its upper edge 20 mm above the height of the grasps."""
    box = trimesh.creation.box((thickness, 0.04, height))
    return box.apply_translation((x, 0, 0.02 - height / 2))


@pytest.mark.parametrize("angle", [-0.17, 0.0, 0.3, 1.0])
def test_faces_lean_by_half_their_angle_towards_the_tips(angle):
    axis, approach = np.array([[0.0, 0.6, 0.8]]), np.array([[1.0, 0.3, 0.4]])
    ((first, second),) = face_normals(axis, approach, np.array([angle]))
    assert np.arccos(np.clip([-first @ axis[0], second @ axis[0]], -1, 1)) == pytest.approx(
        abs(angle) / 2, abs=1e-7
    )
    assert np.cross(first, second) @ np.cross(axis[0], [1, 0, 0]) == pytest.approx(np.sin(angle))
    # jaws that are farther apart at the tips push an object out, along the approach
    assert [-first[0], -second[0]] == pytest.approx([np.sin(angle / 2)] * 2)


@pytest.mark.parametrize("friction", [0.2, 0.3, 0.5])
def test_a_body_is_squeezed_out_where_half_the_angle_exceeds_the_angle_of_friction(body, friction):
    """The limits that were computed for an SO-101: 22, 33 and 53 degrees."""
    limit = 2 * np.arctan(friction)
    for angle in (0.95 * limit, 1.05 * limit):
        normals = face_normals(ACROSS[None], DOWN, np.array([angle]))
        points = np.array([[-0.02 * ACROSS, 0.02 * ACROSS]])
        (quality,) = ferrari_canny(points, normals, ACROSS[None], np.zeros(3), friction=friction)
        assert (quality > 0) == (angle < limit)
    opening = np.interp(limit, body.model.angles, body.model.openings)
    expected = {0.2: 0.045, 0.3: 0.060, 0.5: body.model.openings[-1]}[friction]
    assert opening == pytest.approx(expected, abs=0.003)


def test_balls_are_held_up_to_the_width_at_which_they_are_squeezed_out(body):
    """With friction 0.2: 22.6 degrees, to which the hand opens at 46 mm."""
    settings = label_parameters(body.gripper, 20, 0, friction=0.2, cone=0.05, approach_angles=4)
    labeller, held = Labeller(settings), {}
    for diameter in (0.02, 0.036, 0.052):
        ball = trimesh.creation.icosphere(4, diameter / 2)
        table = labeller(ball, np.zeros(3), np.random.default_rng(0)).table
        assert table["fits"].all()
        needed = table["needed_opening"].to_numpy()
        angle = np.interp(needed, body.model.openings, body.model.angles)
        assert (table["quality"].to_numpy() > 0).tolist() == (angle / 2 < np.arctan(0.2)).tolist()
        # a flat face that touches the ball crosses the line of the contacts there, or nearer
        face = diameter / 2 * (1 + 1 / np.cos(angle))
        step = np.diff(body.model.openings).max()
        assert ((needed >= diameter) & (needed <= face + 2 * step)).all()
        held[diameter] = float((table["quality"] > 0).mean())
    assert held == {0.02: 1.0, 0.036: 1.0, 0.052: 0.0}


def test_between_parallel_faces_quality_is_that_of_parallel_jaws(body):
    width = float(np.interp(0.0, body.model.angles, body.model.openings))
    grasp = pair(width)
    faces = JawFaces.of(body, grasp, DOWN, np.array([width]))
    assert faces is not None
    np.testing.assert_allclose(faces.normals(grasp), grasp.normals, atol=1e-6)


def test_the_fixed_jaw_stands_before_its_contact_however_wide_the_hand_opens(body):
    for width in (0.005, 0.02, 0.05):
        opening = np.array([body.gripper.opening])
        aside = body.aside(np.array([width]), opening)[0]
        inner = max(part.box[1, 0] for part in body.at(64, bodies=(-1,))) + aside
        assert inner == pytest.approx(-width / 2 - JAW_CLEARANCE, abs=1e-4)


def test_the_fixed_jaw_fits_where_the_moving_one_does_not(body):
    """Another plate stands 15 mm beside a thin one: more than the fixed jaw is thick."""
    pair_of_plates = trimesh.util.concatenate([plate(0.006), plate(0.006, -0.018)])
    caster = RayCaster(pair_of_plates)
    needed = [float(needed_openings(caster, pair(0.006, way), DOWN, body)[0]) for way in (1, -1)]
    assert needed[0] == pytest.approx(0.006, abs=0.004)
    assert needed[1] > 0.024  # it stops at the other plate
    assert best_approaches(caster, pair(0.006), body, angles=1, way=0.1).free.all()


def test_what_the_moving_jaw_meets_on_its_way_stops_it(body):
    """A post between the open jaw and a plate: the jaw comes to 25 mm before the plate."""
    width, post = 0.006, plate(0.002, 0.027)
    alone = needed_openings(RayCaster(plate(width)), pair(width), DOWN, body)
    assert alone[0] == pytest.approx(width, abs=0.004)
    both = RayCaster(trimesh.util.concatenate([plate(width), post]))
    assert best_approaches(both, pair(width), body, angles=1, way=0.1).free.all()
    stopped = needed_openings(both, pair(width), DOWN, body)
    assert width / 2 + 0.028 < stopped[0] < width / 2 + 0.028 + 0.012


def test_a_hand_whose_fixed_jaw_does_not_fit_needs_more_than_it_has(body):
    blocked = RayCaster(trimesh.util.concatenate([plate(0.006), plate(0.006, -0.008)]))
    assert needed_openings(blocked, pair(0.006), DOWN, body)[0] == np.inf
