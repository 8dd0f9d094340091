import numpy as np

from egad.detectors import prepare_input, read_maps
from egad.detectors.maps import MAX_PEAKS, best, peaks
from egad.learning.images import agrees
from egad.learning.targets import targets


def twin(rectangles, size):
    """The same maps pixel by pixel, from the definition."""
    maps = np.zeros((4, size, size), np.float32)
    for u, v, angle, opening, breadth in rectangles:
        for row in range(size):
            for column in range(size):
                x, y = column - u, v - row
                along = np.cos(angle) * x + np.sin(angle) * y
                aside = np.cos(angle) * y - np.sin(angle) * x
                if abs(along) <= opening / 6 and abs(aside) <= breadth / 2:
                    code = np.cos(2 * angle), np.sin(2 * angle), min(opening, 150) / 150
                    maps[:, row, column] = (1, *code)
    return maps


def test_maps_are_those_of_an_obvious_twin():
    rng = np.random.default_rng(0)
    low, high = [-10, -10, -np.pi / 2, 0, 0], [70, 70, np.pi / 2, 200, 30]
    rectangles = rng.uniform(low, high, (30, 5))
    np.testing.assert_allclose(targets(rectangles, 60), twin(rectangles, 60), atol=1e-6)


def test_what_is_painted_can_be_read_again():
    """The best grasp of a painted map is the one that was painted."""
    for turn in (-1.5, -0.7, 0.0, 0.4, 1.2):
        truth = np.array([[120.0, 170.0, turn, 60.0, 24.0]])
        found = best(read_maps(targets(truth)))
        assert agrees(found, truth)
        assert abs((found[2] - turn + np.pi / 2) % np.pi - np.pi / 2) < 0.01


def test_depths_go_in_less_their_mean_and_clipped():
    depth = np.array([[0.5, 0.7], [0.6, 9.0]])
    np.testing.assert_allclose(prepare_input(depth), [[-1, -1], [-1, 1]])
    np.testing.assert_allclose(prepare_input(depth[:1]), [[-0.1, 0.1]], atol=1e-7)


def test_half_certain_networks_do_not_ask_for_half_of_the_opening():
    """The best that a network can learn where a grasp is there every other time."""
    painted = targets(np.array([[150.0, 120.0, 0.7, 60.0, 30.0]]))
    for certainty in (1.0, 0.5, 0.1):
        np.testing.assert_allclose(
            best(read_maps(certainty * painted)), [150, 120, 0.7, 60], rtol=1e-3, atol=1e-3
        )


def test_where_there_is_no_grasp_the_opening_has_its_bounds():
    maps = np.zeros((4, 60, 60))
    maps[3] = np.linspace(-1, 1, 60)
    opening = read_maps(maps).opening
    assert np.isfinite(opening).all()
    assert (opening.min(), opening.max()) == (0, 150)


def test_peaks_come_from_the_best_on_and_lie_apart():
    rng = np.random.default_rng(0)
    quality = rng.random((200, 200))
    found = peaks(quality)
    assert len(found) == MAX_PEAKS
    values = [quality[place] for place in found]
    assert values == sorted(values, reverse=True)
    assert quality[found[0]] == quality.max()
    rows, columns = np.array(found).T
    apart = np.maximum(np.abs(rows[:, None] - rows), np.abs(columns[:, None] - columns))
    assert apart[~np.eye(len(found), dtype=bool)].min() > 10
