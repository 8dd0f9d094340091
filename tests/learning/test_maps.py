import numpy as np

from egad.learning.targets import MOST_PEAKS, best, peaks, prepared, read, targets


def test_depths_go_in_less_their_mean_and_clipped():
    depth = np.array([[0.5, 0.7], [0.6, 9.0]])
    np.testing.assert_allclose(prepared(depth), [[-1, -1], [-1, 1]])
    np.testing.assert_allclose(prepared(depth[:1]), [[-0.1, 0.1]], atol=1e-7)


def test_maps_are_read_as_they_are_coded():
    angle = 0.4
    maps = (
        np.ones((4, 60, 60))
        * np.array([0.5, np.cos(2 * angle), np.sin(2 * angle), 0.3])[:, None, None]
    )
    answer = read(maps)
    np.testing.assert_allclose(answer.quality, 0.5)
    np.testing.assert_allclose(answer.angle, angle)
    np.testing.assert_allclose(answer.opening, 90)


def test_half_certain_networks_do_not_ask_for_half_of_the_opening():
    """The best that a network can learn where a grasp is there every other time."""
    painted = targets(np.array([[150.0, 120.0, 0.7, 60.0, 30.0]]))
    for certainty in (1.0, 0.5, 0.1):
        np.testing.assert_allclose(
            best(read(certainty * painted)), [150, 120, 0.7, 60], rtol=1e-3, atol=1e-3
        )


def test_where_there_is_no_grasp_the_opening_has_its_bounds():
    maps = np.zeros((4, 60, 60))
    maps[3] = np.linspace(-1, 1, 60)
    opening = read(maps).opening
    assert np.isfinite(opening).all()
    assert (opening.min(), opening.max()) == (0, 150)


def test_peaks_come_from_the_best_on_and_lie_apart():
    rng = np.random.default_rng(0)
    quality = rng.random((200, 200))
    found = peaks(quality)
    assert len(found) == MOST_PEAKS
    values = [quality[place] for place in found]
    assert values == sorted(values, reverse=True)
    assert quality[found[0]] == quality.max()
    rows, columns = np.array(found).T
    apart = np.maximum(np.abs(rows[:, None] - rows), np.abs(columns[:, None] - columns))
    assert apart[~np.eye(len(found), dtype=bool)].min() > 10


def test_the_best_grasp_is_a_column_a_row_an_angle_and_an_opening():
    maps = np.zeros((4, 100, 100))
    maps[0, 30, 70] = 1
    maps[1], maps[3] = 1, 0.2
    found = best(read(maps))
    np.testing.assert_allclose(found[:3], [70, 30, 0])
    assert found[3] > 30  # less certain than 1 after smoothing
