import numpy as np
import pytest
import scipy.sparse

from egad.geometry.refinement import face_areas, refine
from egad.reeb.geodesics import edge_graph, even_integral, scan_integral


@pytest.fixture
def fine(lumpy, triangulate):
    return refine(triangulate(lumpy), 300)


@pytest.fixture
def distances(fine):
    corners = fine.vertices[fine.edges]
    lengths = np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1)
    graph = scipy.sparse.coo_array((lengths, fine.edges.T), shape=(300, 300)).tocsr()
    return scipy.sparse.csgraph.dijkstra(graph, directed=False)


def even(fine, count):
    graph = edge_graph(fine, shortcuts=False)
    return even_integral(graph, fine.vertices, fine.faces, face_areas(fine), count)


def shares(fine):
    return np.bincount(fine.faces.ravel(), np.repeat(face_areas(fine) / 3, 3))


@pytest.mark.parametrize("count", [300, 1000])
def test_even_bases_at_every_vertex_give_the_integral_as_defined(fine, distances, count):
    assert even(fine, count) == pytest.approx(distances @ shares(fine))


@pytest.mark.parametrize("count", [1, 2, 20])
def test_even_bases_are_the_farthest_points(fine, distances, count):
    share = shares(fine)
    centre = share @ fine.vertices / share.sum()
    bases = [np.linalg.norm(fine.vertices - centre, axis=1).argmax()]
    while len(bases) < count:
        bases.append(distances[bases].min(axis=0).argmax())
    owner = distances[bases].argmin(axis=0)
    weights = np.bincount(owner, share, count)
    assert even(fine, count) == pytest.approx(weights @ distances[bases])


def test_scan_bases_walk_the_vertices_in_order(fine, distances):
    areas, radius = face_areas(fine), 0.7
    covered, expected = np.zeros(300, bool), np.zeros(300)
    for base in range(300):
        if not covered[base]:
            fresh = ~covered & (distances[base] <= radius)
            covered |= fresh
            expected += areas[fresh[fine.faces].any(axis=1)].sum() * distances[base]
    found = scan_integral(edge_graph(fine, shortcuts=False), fine.faces, areas, radius)
    assert found == pytest.approx(expected)
