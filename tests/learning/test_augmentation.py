import numpy as np
import pytest

from egad.learning.augmentation import Change, change_depth, change_rectangles, sample_change


def marked(u, v):
    """An image that is brightest at a place."""
    x, y = np.meshgrid(np.arange(300), np.arange(300))
    return np.exp(-((x - u) ** 2 + (y - v) ** 2) / 200)


@pytest.mark.parametrize("turns", range(4))
@pytest.mark.parametrize("zoom", [1.0, 0.8, 0.5])
def test_grasps_go_where_their_place_in_the_image_goes(turns, zoom):
    change = Change(turns, zoom)
    moved = change_rectangles(np.array([[170.0, 120.0, 0.2, 40.0, 10.0]]), change, 300)[0]
    row, column = np.unravel_index(change_depth(marked(170, 120), change).argmax(), (300, 300))
    np.testing.assert_allclose([column, row], moved[:2], atol=1.0)
    np.testing.assert_allclose(moved[3:], np.array([40, 10]) / zoom)


@pytest.mark.parametrize("turns", range(4))
def test_angles_turn_with_the_image(turns):
    """The far end of the axis is where the image of that place is."""
    center, end = np.array([150.0, 140.0]), np.array([190.0, 120.0])
    angle = np.arctan2(-(end - center)[1], (end - center)[0])
    rows = np.array([[*center, angle, 40, 10], [*end, 0, 1, 1]])
    moved = change_rectangles(rows, Change(turns, 0.7), 300)
    away = moved[1, :2] - moved[0, :2]
    off = moved[0, 2] - np.arctan2(-away[1], away[0])
    assert np.sin(off) == pytest.approx(0, abs=1e-9)
    assert -np.pi / 2 <= moved[0, 2] < np.pi / 2


def test_four_turns_and_no_turn_are_the_same():
    depth = np.random.default_rng(0).random((300, 300))
    np.testing.assert_array_equal(change_depth(depth, Change(4)), depth)
    rows = np.random.default_rng(0).uniform(-1, 1, (5, 5))
    np.testing.assert_allclose(
        change_rectangles(rows, Change(4), 300), change_rectangles(rows, Change(), 300)
    )


def test_the_depths_stay_as_they_are():
    seen = change_depth(np.full((300, 300), 0.6), Change(1, 0.6))
    np.testing.assert_allclose(seen, 0.6)


def test_changes_are_drawn_within_their_bounds():
    rng = np.random.default_rng(0)
    found = [sample_change((0.5, 0.9), rng) for _ in range(200)]
    assert {change.turns for change in found} == {0, 1, 2, 3}
    assert 0.5 <= min(each.zoom for each in found) < 0.52
    assert 0.88 < max(each.zoom for each in found) <= 0.9
