import numpy as np
import pytest
import trimesh

from egad.grasps.opening import fitting_part, pinch_widths


def test_a_bar_fits_crosswise_but_not_lengthwise():
    bar = trimesh.creation.box((0.1, 0.02, 0.03))
    widths, areas = pinch_widths(bar)
    assert np.unique(widths.round(9)).tolist() == [0.02, 0.03, 0.1]
    assert areas.sum() == pytest.approx(bar.area)
    across, along, ends = (2 * a * b for a, b in [(0.1, 0.03), (0.1, 0.02), (0.02, 0.03)])
    assert fitting_part(widths, areas, 0.019) == 0
    assert fitting_part(widths, areas, 0.025) == pytest.approx(across / bar.area)
    assert fitting_part(widths, areas, 0.05) == pytest.approx((across + along) / bar.area)
    assert fitting_part(widths, areas, 0.2) == 1
    assert ends + across + along == pytest.approx(bar.area)


def test_widths_grow_with_the_object():
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.03)
    widths, _ = pinch_widths(ball)
    assert widths == pytest.approx(0.06, rel=0.01)
    larger, _ = pinch_widths(trimesh.Trimesh(2 * ball.vertices, ball.faces))
    assert larger == pytest.approx(2 * widths)


def test_the_wall_of_a_pipe_fits_where_the_pipe_does_not():
    pipe = trimesh.creation.annulus(0.02, 0.022, 0.1, sections=64)
    widths, areas = pinch_widths(pipe)
    assert fitting_part(widths, areas, 0.0025) > 0.9
