import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from egad.learning.images import agrees
from egad.learning.images.rectangles import overlap

SQUARE = np.array([10.0, 20.0, 0.0, 6.0, 6.0])


def inside(rectangle, points):
    """Which points (n, 2) of u and v lie in a rectangle, from its definition."""
    u, v, angle, opening, breadth = rectangle
    along = np.array([np.cos(angle), -np.sin(angle)])
    away = points - (u, v)
    return (np.abs(away @ along) <= opening / 2) & (
        np.abs(away @ [-along[1], along[0]]) <= breadth / 2
    )


def moved(u, v, turn=0.0):
    return np.add(SQUARE, (u, v, turn, 0, 0))


def rectangle_strategy():
    place, side = st.floats(-10, 10), st.floats(2, 20)
    return st.tuples(place, place, st.floats(-2, 2), side, side).map(np.array)


def test_known_overlaps():
    assert overlap(SQUARE, SQUARE) == pytest.approx(1)
    assert overlap(SQUARE, moved(3, 0)) == pytest.approx(1 / 3)
    assert overlap(SQUARE, moved(0, 7)) == 0
    assert overlap(SQUARE, SQUARE * [1, 1, 1, 1, 0]) == 0
    octagon = 2 * (np.sqrt(2) - 1)  # of a unit square and one turned by 45 degrees
    assert overlap(SQUARE, moved(0, 0, np.pi / 4)) == pytest.approx(octagon / (2 - octagon))
    half = SQUARE * [1, 1, 1, 0.5, 1]
    assert overlap(SQUARE, half) == pytest.approx(0.5)


@given(rectangle_strategy(), rectangle_strategy())
@settings(max_examples=15, deadline=None)
def test_overlap_is_what_counting_points_gives(one, other):
    reach = np.hypot(*np.transpose([one, other])[3:]) / 2
    low = np.min([one[:2] - reach[0], other[:2] - reach[1]], axis=0)
    high = np.max([one[:2] + reach[0], other[:2] + reach[1]], axis=0)
    sides = [np.linspace(start, end, 301) for start, end in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)
    here, there = inside(one, points), inside(other, points)
    counted = (here & there).sum() / (here | there).sum()
    assert overlap(one, other) == pytest.approx(counted, abs=0.03)
    assert overlap(other, one) == pytest.approx(overlap(one, other), abs=1e-8)


@pytest.mark.parametrize(
    ("change", "right"),
    [
        ((0, 0, 0, 0), True),
        ((0, 0, np.radians(29), 0), True),
        ((0, 0, np.radians(31), 0), False),
        ((0, 0, np.pi, 0), True),
        ((23, 0, 0, 0), True),  # (40 - 23) / (40 + 23) = 0.27
        ((25, 0, 0, 0), False),  # 15 / 65 = 0.23
        ((0, 0, 0, -29), True),  # 11 / 40 = 0.275
        ((0, 0, 0, -31), False),
    ],
)
def test_right_is_what_overlaps_a_label_and_lies_along_it(change, right):
    far = np.array([200.0, 200.0, 0.0, 40.0, 15.0])
    label = np.array([100.0, 120.0, 1.4, 40.0, 15.0])
    shift, _, turn, wider = change
    change = [shift * np.cos(1.4), -shift * np.sin(1.4), turn, wider]
    assert agrees(label[:4] + change, np.array([far, label])) is right
