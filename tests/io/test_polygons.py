"""Triangles of polygons: they cover the polygon once, as the shoelace formula says."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from egad.errors import RejectedError
from egad.io.polygons import strip_triangles, triangles_of


def star_shaped(radii):
    """A polygon around the origin, mostly concave, wound counter-clockwise."""
    angles = np.arange(len(radii)) * 2 * np.pi / len(radii)
    return np.column_stack([np.cos(angles), np.sin(angles)]) * np.asarray(radii)[:, None]


def shoelace(points):
    x, y = points.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


@settings(max_examples=200, deadline=None, derandomize=True)
@given(
    st.lists(st.floats(0.1, 10.0), min_size=3, max_size=12),
    st.integers(0, 11),
    st.floats(0.0, 6.0),
    st.booleans(),
)
def test_triangles_cover_a_polygon_once(radii, first, angle, backwards):
    flat = np.roll(star_shaped(radii), first % len(radii), axis=0)
    area, order = shoelace(flat), range(len(flat))
    turn = trimesh.transformations.rotation_matrix(angle, [1, 2, 3])[:3, :3]
    vertices = np.column_stack([flat, np.zeros(len(flat))]) @ turn.T
    corners = np.array(order)[::-1] if backwards else np.array(order)
    faces = triangles_of(vertices, corners, np.array([len(flat)]))
    assert faces.shape == (len(flat) - 2, 3)
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    signed = 0.5 * np.cross(b - a, c - a) @ turn[:, 2] * (-1 if backwards else 1)
    assert signed.sum() == pytest.approx(area, rel=1e-9)
    assert (signed > -1e-9 * area).all()
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()
    rim = np.column_stack([corners, np.roll(corners, -1)]).tolist()
    inner = [edge for edge in edges if edge not in rim]
    assert len(inner) == len(edges) - len(rim)  # the rim is there once,
    assert sorted(inner) == sorted(edge[::-1] for edge in inner)  # and the rest in both directions


SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)


def test_order_and_points_and_edges():
    corners, lengths = np.array([0, 1, 2, 3, 2, 0, 1, 1, 2, 3]), np.array([4, 1, 2, 3])
    faces = triangles_of(SQUARE, corners, lengths)
    assert faces.tolist() == [[0, 1, 2], [0, 2, 3], [1, 2, 3]]
    none = np.empty(0, np.int64)
    assert triangles_of(SQUARE, none, none).shape == (0, 3)


def on_circle(count, step):
    angles = np.arange(count) * step * 2 * np.pi / count
    return np.column_stack([np.cos(angles), np.sin(angles)])


CROSSING = {
    "bow-tie": [(0, 0), (10, 10), (10, 0), (0, 8)],
    "bow-tie of no mean normal": [(0, 0), (10, 10), (10, 0), (0, 10)],
    "pentagram": on_circle(5, 2),
    "star 7/2": on_circle(7, 2),
    "star 7/3": on_circle(7, 3),
    "hexagon": [(0, 0), (4, 0), (4, 4), (1, -1), (0, 4), (-1, 2)],
}


@pytest.mark.parametrize("name", CROSSING)
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_a_polygon_that_crosses_itself_is_refused(name, scale):
    flat = scale * np.asarray(CROSSING[name], dtype=float)
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])[:3, :3]
    vertices = np.column_stack([flat, np.zeros(len(flat))]) @ turn.T
    for first in range(len(flat)):
        corners = np.roll(np.arange(len(flat)), first)
        for order in (corners, corners[::-1]):
            with pytest.raises(RejectedError, match="crosses itself"):
                triangles_of(vertices, order, np.array([len(flat)]))


@pytest.mark.parametrize(
    ("polygon", "area"),
    [([0, 1, 1, 2], 0.5), ([0, 1, 0, 1], 0), ([0, 4, 1, 0], 0), ([0, 4, 1, 2], 0.5)],
)
def test_edges_that_run_there_and_back_cross_nothing(polygon, area):
    vertices = np.vstack([SQUARE, [0.5, 0, 0]])
    faces = triangles_of(vertices, np.array(polygon), np.array([len(polygon)]))
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    assert 0.5 * np.cross(b - a, c - a).sum(axis=0)[2] == pytest.approx(area)


def test_a_corner_that_is_not_there_is_refused():
    for corner in (-1, 4):
        with pytest.raises(RejectedError, match="do not exist"):
            triangles_of(SQUARE, np.array([0, 1, corner]), np.array([3]))


def test_strips_turn_by_turns_and_links_are_left_out():
    assert strip_triangles(np.arange(5)).tolist() == [[0, 1, 2], [2, 1, 3], [2, 3, 4]]
    linked = strip_triangles(np.array([0, 1, 2, 2, 3, 3, 4, 5]))
    assert linked.tolist() == [[0, 1, 2], [4, 3, 5]]
