import numpy as np
import pytest

from egad.learning.augmentation import (
    Change,
    Crop,
    change_depth,
    change_rectangles,
    mean_depth,
    sample_change,
    sample_crop,
)


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


def test_changes_are_drawn_within_their_bounds():
    rng = np.random.default_rng(0)
    found = [sample_change((0.5, 0.9), rng) for _ in range(200)]
    assert {change.turns for change in found} == {0, 1, 2, 3}
    assert 0.5 <= min(each.zoom for each in found) < 0.52
    assert 0.88 < max(each.zoom for each in found) <= 0.9


CHANGES = [Change(0, 1.0), Change(1, 0.5), Change(2, 0.731), Change(3, 0.999)]


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("crop", [Crop(0, 0, 300), Crop(17, 132, 168), Crop(204, 0, 96)])
def test_a_crop_is_a_part_of_the_whole_changed_image(change, crop):
    depth = np.random.default_rng(0).random((300, 300))
    row, column, side = crop
    whole = change_depth(depth, change)[row : row + side, column : column + side]
    np.testing.assert_allclose(change_depth(depth, change, crop), whole, atol=1e-9)


@pytest.mark.parametrize("change", CHANGES)
def test_the_mean_is_that_of_all_pixels_of_the_changed_image(change):
    depth = np.random.default_rng(0).random((300, 300))
    assert mean_depth(depth, change) == pytest.approx(change_depth(depth, change).mean(), abs=1e-12)


def crops(rectangles, count=4000, side=96):
    rng = np.random.default_rng(0)
    return np.array([sample_crop(np.array(rectangles), side, rng) for _ in range(count)])


def shows(found, u, v):
    row, column, side = found.T
    return (row <= v) & (v < row + side) & (column <= u) & (u < column + side)


def test_crops_lie_in_the_image_and_everywhere_if_there_is_no_grasp():
    """Their corners are uniform: first and last ones occur, and their mean is the middle."""
    found = crops(np.empty((0, 5)))
    assert found.min(axis=0).tolist() == [0, 0, 96]
    assert found.max(axis=0).tolist() == [204, 204, 96]
    np.testing.assert_allclose(found[:, :2].mean(axis=0), 102, atol=4 * 59 / np.sqrt(4000))
    assert {tuple(crop) for crop in crops(np.empty((0, 5)), 5, 300)} == {(0, 0, 300)}


@pytest.mark.parametrize("place", [(150, 120), (0, 299), (299.4, -0.4)])
def test_three_of_four_crops_aim_at_a_grasp(place):
    """The others show it by chance: as often as those of an image without grasps."""
    grasp = [*place, 0.1, 40, 20]
    u, v = np.clip(np.round(place), 0, 299)
    chance = shows(crops(np.empty((0, 5))), u, v).mean()
    share = shows(crops([grasp]), u, v).mean()
    assert share == pytest.approx(0.75 + 0.25 * chance, abs=0.04)


def test_a_grasp_outside_the_image_is_not_aimed_at():
    outside, inside = [310, 150, 0, 40, 20], [20, 20, 0, 40, 20]
    assert shows(crops([outside, inside]), 20, 20).mean() > 0.7
    assert shows(crops([outside]), 20, 20).mean() < 0.1
