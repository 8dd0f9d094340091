import numpy as np
import pytest
import scipy.sparse
import trimesh

from egad.geometry.refinement import face_areas, refine, triangulation
from egad.measures.reeb.geodesics import edge_graph, even_integral, scan_integral, spread


@pytest.fixture
def fine(lumpy, triangulate):
    return refine(triangulate(lumpy), 600)


def dijkstra(graph, sources):
    rows = (graph.lengths, graph.neighbors.astype(np.int32), graph.starts.astype(np.int32))
    return scipy.sparse.csgraph.dijkstra(scipy.sparse.csr_array(rows), indices=sources)


def search(graph, source):
    distances = np.full(len(graph.starts) - 1, np.inf)
    spread(graph, source, distances)
    return distances


def test_the_graph_has_the_edges_of_the_mesh(fine):
    graph = edge_graph(fine, shortcuts=False)
    owners = np.repeat(np.arange(600), np.diff(graph.starts.astype(int)))
    pairs = np.stack((owners, graph.neighbors), axis=1)
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


@pytest.fixture
def coarse(lumpy, triangulate):
    return refine(triangulate(lumpy), 300)


@pytest.fixture
def distances(coarse):
    corners = coarse.vertices[coarse.edges]
    lengths = np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1)
    graph = scipy.sparse.coo_array((lengths, coarse.edges.T), shape=(300, 300)).tocsr()
    return scipy.sparse.csgraph.dijkstra(graph, directed=False)


def even(coarse, count):
    graph = edge_graph(coarse, shortcuts=False)
    return even_integral(graph, coarse.vertices, coarse.faces, face_areas(coarse), count)


def shares(coarse):
    return np.bincount(coarse.faces.ravel(), np.repeat(face_areas(coarse) / 3, 3))


@pytest.mark.parametrize("count", [300, 1000])
def test_even_bases_at_every_vertex_give_the_integral_as_defined(coarse, distances, count):
    assert even(coarse, count) == pytest.approx(distances @ shares(coarse))


@pytest.mark.parametrize("count", [1, 2, 20])
def test_even_bases_are_the_farthest_points(coarse, distances, count):
    share = shares(coarse)
    center = share @ coarse.vertices / share.sum()
    bases = [np.linalg.norm(coarse.vertices - center, axis=1).argmax()]
    while len(bases) < count:
        bases.append(distances[bases].min(axis=0).argmax())
    owner = distances[bases].argmin(axis=0)
    weights = np.bincount(owner, share, count)
    assert even(coarse, count) == pytest.approx(weights @ distances[bases])


def test_scan_bases_walk_the_vertices_in_order(coarse, distances):
    areas, radius = face_areas(coarse), 0.7
    covered, expected = np.zeros(300, bool), np.zeros(300)
    for base in range(300):
        if not covered[base]:
            fresh = ~covered & (distances[base] <= radius)
            covered |= fresh
            expected += areas[fresh[coarse.faces].any(axis=1)].sum() * distances[base]
    found = scan_integral(edge_graph(coarse, shortcuts=False), coarse.faces, areas, radius)
    assert found == pytest.approx(expected)
