import numpy as np

from egad.vision.maps import MOST_PEAKS, best, peaks, prepared, read


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
    np.testing.assert_allclose(answer.opening, 45)


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
    np.testing.assert_allclose(best(read(maps)), [70, 30, 0, 30])
