import itertools

import networkx as nx
import numpy as np
import pytest
import trimesh

from egad.geometry.refinement import triangulation
from egad.measures.reeb.ranges import cut


def area_below(mesh, height):
    """Area of the part of a mesh below a height: every triangle is clipped as a polygon."""
    total = 0.0
    for triangle in mesh.triangles:
        kept = []
        for one, other in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
            if one[2] <= height:
                kept.append(one)
            if (one[2] <= height) != (other[2] <= height):
                kept.append(one + (other - one) * (height - one[2]) / (other[2] - one[2]))
        for b, c in itertools.pairwise(kept[1:]):
            total += np.linalg.norm(np.cross(b - kept[0], c - kept[0])) / 2
    return total


def test_areas_are_those_between_planes(lumpy, triangulate):
    low, high = lumpy.bounds[:, 2]
    values = (lumpy.vertices[:, 2] - low) * (10 / (high - low) * (1 - 1e-12))
    parts = cut(triangulate(lumpy), lumpy.area_faces, values)
    expected = np.diff([area_below(lumpy, height) for height in np.linspace(low, high, 11)])
    assert np.bincount(parts.ranges, parts.areas) == pytest.approx(expected)
    assert parts.areas.sum() == pytest.approx(lumpy.area)


def test_the_parts_of_a_torus_form_a_ring(triangulate):
    mesh = trimesh.creation.torus(3, 1, major_sections=64, minor_sections=32)
    values = (mesh.vertices[:, 0] + 4) * (10 / 8 * (1 - 1e-9))
    parts = cut(triangulate(mesh), mesh.area_faces, values)
    assert np.bincount(parts.ranges).tolist() == [1, 1, 1, 2, 2, 2, 2, 1, 1, 1]
    assert parts.lengths == pytest.approx(np.ones(14), abs=1e-6)
    assert (np.diff(parts.ranges[parts.links]) == 1).all()
    assert len(nx.cycle_basis(nx.Graph(parts.links.tolist()))) == 1
    two = parts.areas[parts.ranges == 4]
    assert two[0] == pytest.approx(two[1])


def test_a_part_spans_what_it_covers_of_its_range():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    mesh = triangulation(vertices, np.array([[0, 1, 2]], np.int32))
    parts = cut(mesh, np.array([0.5]), np.array([0.25, 0.5, 2.75]))
    assert sorted(zip(parts.ranges, parts.lengths, strict=True)) == [(0, 0.75), (1, 1), (2, 0.75)]


def test_a_value_on_a_limit_belongs_to_the_range_above():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    mesh = triangulation(vertices, np.array([[0, 1, 2]], np.int32))
    parts = cut(mesh, np.array([0.5]), np.array([0.0, 1.0, 2.0]))
    order = np.argsort(parts.ranges)
    assert parts.ranges[order].tolist() == [0, 1, 2]
    assert parts.areas[order] == pytest.approx([0.25, 0.25, 0])


def test_parts_that_touch_at_a_vertex_are_one():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], float)
    mesh = triangulation(vertices, np.array([[0, 1, 2], [0, 3, 4]], np.int32))
    parts = cut(mesh, np.array([0.5, 0.5]), np.array([0.5, 0.1, 0.9, 0.1, 0.9]))
    assert parts.areas.tolist() == [1.0]
