import numpy as np
import pytest
import trimesh

from egad.exchange.rescaled_files import graspable_fraction, graspable_widths


def test_a_bar_fits_crosswise_but_not_lengthwise():
    bar = trimesh.creation.box((0.1, 0.02, 0.03))
    widths, areas = graspable_widths(bar)
    assert np.unique(widths.round(9)).tolist() == [0.02, 0.03, 0.1]
    assert areas.sum() == pytest.approx(bar.area)
    across, along, ends = (2 * a * b for a, b in [(0.1, 0.03), (0.1, 0.02), (0.02, 0.03)])
    assert graspable_fraction(widths, areas, 0.019) == 0
    assert graspable_fraction(widths, areas, 0.025) == pytest.approx(across / bar.area)
    assert graspable_fraction(widths, areas, 0.05) == pytest.approx((across + along) / bar.area)
    assert graspable_fraction(widths, areas, 0.2) == 1
    assert ends + across + along == pytest.approx(bar.area)


def test_widths_grow_with_the_object():
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.03)
    widths, _ = graspable_widths(ball)
    assert widths == pytest.approx(0.06, rel=0.01)
    larger, _ = graspable_widths(trimesh.Trimesh(2 * ball.vertices, ball.faces))
    assert larger == pytest.approx(2 * widths)


def test_the_wall_of_a_pipe_fits_where_the_pipe_does_not():
    pipe = trimesh.creation.annulus(0.02, 0.022, 0.1, sections=64)
    widths, areas = graspable_widths(pipe)
    assert graspable_fraction(widths, areas, 0.0025) > 0.9
