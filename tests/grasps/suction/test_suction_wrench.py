import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from egad.grasps.suction import loads_in_frames, resists
from egad.grippers import SuctionCup

STRICT = SuctionCup(torque_tolerance=0)
ROOT_2, ROOT_3 = np.sqrt([2, 3])


def limits(cup, friction):
    """Rows of A x <= b for a load x on a cup whose z points outwards, pressing positive."""
    rows = []
    for axis in (0, 1):
        rows += [(sign * ROOT_3 * np.eye(6)[axis], friction) for sign in (1, -1)]
    rows += [(sign * ROOT_3 * np.eye(6)[5], friction * cup.radius) for sign in (1, -1)]
    a = [row - share * np.eye(6)[2] for row, share in rows]
    b = [share * cup.vacuum_force for _, share in rows]
    for axis in (3, 4):
        for sign in (1, -1):
            a.append(sign * ROOT_2 * np.eye(6)[axis])
            b.append(np.pi * cup.radius * cup.bending)
    a.append(-np.eye(6)[2])
    b.append(cup.vacuum_force)
    assert len(a) == 11
    return np.array(a), np.array(b)


def grasp_matrix(rotation, arm):
    """(6, 6) from a load in the frame of the contact to the wrench about the center of mass.

    Args:
        rotation: Axes of the contact in columns.
        arm: From the center of mass to the contact.
    """
    x, y, z = arm
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.block([[rotation, np.zeros((3, 3))], [cross @ rotation, rotation]])


def feasible(cup, matrix, wrench, friction):
    """Whether a linear program finds a load within the limits with this wrench."""
    a, b = limits(cup, friction)
    found = linprog(np.zeros(6), a, b, matrix, wrench, bounds=(None, None), method="highs")
    return found.status == 0


def test_the_inversion_agrees_with_a_linear_program():
    """Forces act at points near the contact, on cups of all kinds."""
    rng = np.random.default_rng(5)
    cases = []
    for _ in range(150):
        cup = SuctionCup(
            radius=rng.uniform(0.005, 0.03),
            vacuum_force=rng.uniform(1, 50),
            bending=10 ** rng.uniform(-2, 0.5),
            torque_tolerance=0,
        )
        friction = rng.uniform(0.1, 1)
        turn = Rotation.random(random_state=rng).as_matrix()
        com, contact = rng.normal(0, 0.05, (2, 3))
        force = rng.normal(0, cup.vacuum_force * rng.choice([0.1, 0.5]), 3)
        at = contact + rng.normal(0, 10 ** rng.uniform(-4, -2.5), 3)
        wrench = np.concatenate([force, np.cross(at - com, force)])
        inwards = turn * [1, -1, -1]  # our z is the approach
        load = loads_in_frames(contact[None], inwards.T[None], force[None], at)
        cases.append(
            (
                bool(resists(cup, load, friction)[0]),
                feasible(cup, grasp_matrix(turn, contact - com), wrench, friction),
            )
        )
    ours, theirs = np.array(cases).T
    assert_array_equal(ours, theirs)
    assert 40 < ours.sum() < 110


@pytest.mark.parametrize("axis", range(6))
def test_each_limit_is_where_the_table_has_it(axis):
    pressed = STRICT.friction * STRICT.vacuum_force / ROOT_3
    bend = np.pi * STRICT.radius * STRICT.bending / ROOT_2
    limit = [pressed, pressed, STRICT.vacuum_force, bend, bend, STRICT.radius * pressed][axis]
    loads = np.outer([0.999, 1.001, -0.999, -1.001], np.eye(6)[axis] * limit)
    expected = [True, False, True, axis == 2]  # the object may press on the cup with any force
    assert resists(STRICT, loads).tolist() == expected


def test_pulling_lowers_friction_and_pressing_raises_it():
    side = STRICT.friction * STRICT.vacuum_force / ROOT_3
    loads = np.zeros((3, 6))
    loads[:, 0] = 0.9 * side
    loads[:, 2] = [0, 0.2 * STRICT.vacuum_force, -STRICT.vacuum_force]
    assert resists(STRICT, loads).tolist() == [True, False, True]
    loads[:, 0] = 1.9 * side
    assert resists(STRICT, loads).tolist() == [False, False, True]
    assert resists(STRICT, loads, [3.0, 3.0, 0.1]).tolist() == [True, True, False]


def test_the_bending_limit_of_the_paper_is_a_hair():
    """1.67e-4 N m: 1 kg hangs at most 0.017 mm beside the axis of the cup."""
    for cup, lever in ((STRICT, 1.667e-4 / 9.81), (SuctionCup(), (1.667e-4 + 0.0316) / 9.81)):
        sides = [[0.99 * lever, 0, 0], [1.01 * lever, 0, 0]]
        pose = np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1))
        loads = loads_in_frames(*pose, np.array([0, 0, 9.81]), np.array(sides))
        assert resists(cup, loads).tolist() == [True, False]


def test_loads_are_forces_and_torques_in_the_frame_of_the_cup():
    frame = Rotation.from_rotvec([0.3, -1.2, 0.7]).as_matrix()
    origin, force, at = np.array([[1.0, 2, 3]]), np.array([[4.0, -5, 6]]), np.array([0.5, 0.1, -2])
    (load,) = loads_in_frames(origin, frame[None], force, at)
    assert_allclose(load[:3], frame @ force[0])
    assert_allclose(load[3:], frame @ np.cross(at - origin[0], force[0]))


def unit_forces(count):
    """Directions spread evenly over a sphere."""
    z = 1 - (2 * np.arange(count) + 1) / count
    turn = np.pi * (1 + np.sqrt(5)) * np.arange(count)
    flat = np.sqrt(1 - z**2)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])


def score(lever, normal_along_lever):
    """Share of forces of 1 N at the center of mass that are resisted, as in GraspGen."""
    center = [0, 0, lever] if normal_along_lever else [lever, 0, 0]
    forces = unit_forces(4000)
    pose = np.zeros((4000, 3)), np.tile(np.eye(3), (4000, 1, 1))
    return resists(SuctionCup(), loads_in_frames(*pose, forces, np.array(center))).mean()


@pytest.mark.parametrize("lever", [0.02, 0.0315, 0.0325, 0.04, 0.05, 0.08, 0.2])
def test_the_score_of_graspgen_has_the_closed_form_of_its_tolerance(lever):
    share = min(0.0318 / lever, 1)
    assert score(lever, True) == pytest.approx(1 - np.sqrt(1 - share**2), abs=0.005)
    assert score(lever, False) == pytest.approx(share, abs=0.005)


@pytest.mark.parametrize(
    ("lever", "along", "across"), [(0.04, 0.41, 0.78), (0.05, 0.21, 0.64), (0.08, 0.08, 0.42)]
)
def test_the_score_is_that_of_graspgens_solver(lever, along, across):
    """Their function on 400 random directions, so within three standard errors."""
    for found, expected in ((score(lever, True), along), (score(lever, False), across)):
        assert abs(found - expected) < 3 * np.sqrt(expected * (1 - expected) / 400)
