"""Errors of a real cell: as large as asked for, and each on its own the same as among others."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from egad.bench import NAMED_ERRORS, CellErrors
from egad.bench.cell_errors import EXACT, Deviation, draw
from egad.detectors import Grasp
from egad.grippers import GRIPPERS

HAND = GRIPPERS["panda"]
GRASP = Grasp((0.03, -0.02, 0.04), 0.7, 0.05, 0.01, 0.9)


def turn_of(deviation: Deviation) -> np.ndarray:
    """The rotation vector, degrees."""
    vector: np.ndarray = np.degrees(Rotation.from_matrix(deviation.motion[:3, :3]).as_rotvec())
    return vector


def test_without_errors_everything_is_as_planned() -> None:
    drawn = draw(CellErrors(), 3, 4)
    np.testing.assert_array_equal(drawn.motion, np.eye(4))
    assert (drawn.opening, drawn.friction, drawn.mass, drawn.stopping_force) == (0, 1, 1, 1)
    for deviation in (drawn, EXACT):
        assert deviation.apply(GRASP, HAND) == GRASP
        planned = Grasp.of_pose(np.eye(4), 0.05, 0.5)
        np.testing.assert_array_equal(deviation.apply(planned, HAND).pose, planned.pose)


def test_errors_are_as_large_as_their_settings_say() -> None:
    errors = CellErrors(
        calibration=0.003,
        calibration_turn=0.5,
        positioning=0.004,
        opening=0.001,
        friction=(0.5, 1.5),
        mass=(0.8, 1.2),
        stopping_force=(1.0, 2.0),
    )
    drawn = [draw(errors, number, 7 * number) for number in range(4000)]
    shifts = np.array([each.motion[:3, 3] for each in drawn])
    np.testing.assert_allclose(shifts.std(axis=0), 0.005, rtol=0.05)  # of both together
    np.testing.assert_allclose(shifts.mean(axis=0), 0, atol=3e-4)
    np.testing.assert_allclose(np.std([turn_of(each) for each in drawn], axis=0), 0.5, rtol=0.05)
    assert np.std([each.opening for each in drawn]) == pytest.approx(0.001, rel=0.05)
    for name, low, high in (("friction", 0.5, 1.5), ("mass", 0.8, 1.2), ("stopping_force", 1, 2)):
        values = np.array([getattr(each, name) for each in drawn])
        assert low <= values.min() < values.max() <= high
        assert values.mean() == pytest.approx((low + high) / 2, rel=0.03)
        assert values.std() == pytest.approx((high - low) / 12**0.5, rel=0.05)


def test_a_calibration_lasts_for_a_session_and_the_rest_changes() -> None:
    lasting = CellErrors(calibration=0.003, calibration_turn=0.5)
    for seed in (1, 2):
        np.testing.assert_array_equal(draw(lasting, 5, seed).motion, draw(lasting, 5, 0).motion)
    assert not np.allclose(draw(lasting, 6, 0).motion, draw(lasting, 5, 0).motion)
    changing = CellErrors(positioning=0.001)
    assert not np.allclose(draw(changing, 5, 0).motion, draw(changing, 5, 1).motion)
    np.testing.assert_array_equal(draw(changing, 5, 0).motion, draw(changing, 6, 0).motion)


def test_an_error_alone_is_drawn_as_among_the_others() -> None:
    typical = NAMED_ERRORS["typical"]
    whole = draw(typical, 8, 9)
    alone = {
        name: draw(CellErrors(**{name: getattr(typical, name)}), 8, 9)
        for name in CellErrors.model_fields
    }
    moved = sum(alone[name].motion[:3, 3] for name in ("calibration", "positioning"))
    np.testing.assert_allclose(whole.motion[:3, 3], moved, atol=1e-15)
    np.testing.assert_array_equal(turn_of(whole), turn_of(alone["calibration_turn"]))
    for name in ("opening", "friction", "mass", "stopping_force"):
        assert getattr(whole, name) == getattr(alone[name], name)


def test_a_turn_of_the_calibration_moves_what_is_off_the_middle_of_the_table() -> None:
    drawn = draw(CellErrors(calibration_turn=5), 1, 1)
    matrix = Rotation.from_rotvec(np.radians(turn_of(drawn))).as_matrix()
    moved = drawn.apply(GRASP, HAND)
    np.testing.assert_allclose(moved.center, matrix @ GRASP.center, atol=1e-12)
    middle = drawn.apply(Grasp((0.0, 0.0, 0.0), 0.0, 0.05, 0.0, 1.0), HAND)
    assert middle.center == (0, 0, 0)
    # The closing axis turns as it does seen from above.
    axis = matrix @ [np.cos(GRASP.angle), np.sin(GRASP.angle), 0]
    assert moved.angle == pytest.approx(np.arctan2(axis[1], axis[0]), abs=1e-12)
    posed = drawn.apply(Grasp.of_pose(np.diag([1.0, -1, -1, 1]), 0.05, 1.0), HAND)
    np.testing.assert_allclose(posed.pose[:3, :3], matrix @ np.diag([1.0, -1, -1]), atol=1e-12)


def test_a_hand_opens_neither_wider_than_it_can_nor_less_than_not_at_all() -> None:
    for opening, width in ((1.0, HAND.opening), (-1.0, 0.0), (0.01, 0.06)):
        assert Deviation(opening=opening).apply(GRASP, HAND).width == pytest.approx(width)
