import numpy as np
import pytest
import scipy.sparse
import trimesh

from egad.geometry.refinement import refine, triangulation
from egad.reeb.geodesics import edge_graph, spread


@pytest.fixture
def fine(lumpy, triangulate):
    return refine(triangulate(lumpy), 600)


def dijkstra(graph, sources):
    rows = (graph.lengths, graph.neighbours.astype(np.int32), graph.starts.astype(np.int32))
    return scipy.sparse.csgraph.dijkstra(scipy.sparse.csr_array(rows), indices=sources)


def search(graph, source):
    distances = np.full(len(graph.starts) - 1, np.inf)
    spread(graph, source, distances)
    return distances


def test_the_graph_has_the_edges_of_the_mesh(fine):
    graph = edge_graph(fine, shortcuts=False)
    owners = np.repeat(np.arange(600), np.diff(graph.starts.astype(int)))
    pairs = np.stack((owners, graph.neighbours), axis=1)
    both = np.concatenate((fine.edges, fine.edges[:, ::-1]))
    assert np.array_equal(np.unique(pairs, axis=0), np.unique(both, axis=0))
    straight = np.linalg.norm(fine.vertices[pairs[:, 0]] - fine.vertices[pairs[:, 1]], axis=1)
    assert graph.lengths == pytest.approx(straight)


@pytest.mark.parametrize("shortcuts", [False, True])
def test_distances_equal_those_of_scipy(fine, shortcuts):
    graph, sources = edge_graph(fine, shortcuts), [0, 17, 599]
    found = [search(graph, source) for source in sources]
    assert np.array_equal(found, dijkstra(graph, sources))


@pytest.mark.parametrize("width", [1e-3, 0.3, 30.0])
def test_the_width_of_the_buckets_does_not_matter(fine, width):
    graph = edge_graph(fine, shortcuts=True)
    buckets = 2 ** int(np.ceil(np.log2(graph.lengths.max() / width + 2)))
    other = graph._replace(scale=1 / width, first=np.full(buckets, -1, np.int32))
    assert np.array_equal(search(other, 5), search(graph, 5))


def test_several_sources_in_turn_give_the_distance_to_the_nearest(fine):
    graph, sources = edge_graph(fine, shortcuts=False), [3, 200, 77]
    nearest = np.full(600, np.inf)
    for source in sources:
        spread(graph, source, nearest)
    assert np.array_equal(nearest, dijkstra(graph, sources).min(axis=0))


def test_what_cannot_be_reached_is_infinitely_far():
    vertices = np.random.default_rng(0).normal(size=(6, 3))
    mesh = triangulation(vertices, np.array([[0, 1, 2], [3, 4, 5]], np.int32))
    assert (
        np.isinf(search(edge_graph(mesh, shortcuts=True), 0)).tolist() == [False] * 3 + [True] * 3
    )


@pytest.mark.parametrize(
    ("corner", "expected"),
    [([0, 1, 1], 2), ([0, 5, 1], np.sqrt(2) + np.sqrt(10))],
    ids=["across the edge", "past its end"],
)
def test_a_shortcut_is_the_line_across_an_edge_when_flat(corner, expected):
    vertices = np.array([[0, 0, 0], [0, 2, 0], [1, 1, 0], corner], float)  # folded at x = 0
    mesh = triangulation(vertices, np.array([[0, 1, 2], [1, 0, 3]], np.int32))
    assert search(edge_graph(mesh, shortcuts=True), 2)[3] == pytest.approx(expected)


def test_shortcuts_bring_distances_nearer_to_the_true_ones(triangulate):
    sphere = triangulate(trimesh.creation.icosphere(subdivisions=4))
    true = np.arccos(np.clip(sphere.vertices @ sphere.vertices[0], -1, 1))[1:]
    along, across = (search(edge_graph(sphere, s), 0)[1:] / true - 1 for s in (False, True))
    assert across.min() > -0.001  # chords are a little shorter than arcs
    assert 0 < across.mean() < along.mean() / 2
