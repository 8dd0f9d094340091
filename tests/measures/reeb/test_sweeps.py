import numpy as np
import pytest
import scipy.sparse

from egad.geometry.refinement import face_areas, refine, triangulation
from egad.measures.reeb.geodesics import edge_graph, even_integral, spread
from egad.measures.reeb.sweeps import LANES, order_of, renumber, sweep, weighted_distances


def swept(graph, order, sources):
    """Distances of each vertex to the sources, (n, s)."""
    rank = np.argsort(order)
    rows = renumber(graph.starts, graph.neighbors, graph.lengths, order, rank)
    return sweep(rows, rank[sources])[rank, : len(sources)]


def dijkstra(graph, sources):
    rows = (graph.lengths, graph.neighbors.astype(np.int32), graph.starts.astype(np.int32))
    return scipy.sparse.csgraph.dijkstra(scipy.sparse.csr_array(rows), indices=sources).T


def search(graph, source):
    distances = np.full(len(graph.starts) - 1, np.inf)
    spread(graph, source, distances)
    return distances


def integral_base_by_base(mesh, graph, areas, count):
    """The integral with a whole search from every base."""
    share = np.zeros(len(mesh.vertices))
    for face, area in zip(mesh.faces, areas, strict=True):
        for vertex in face:
            share[vertex] += area / 3
    squares = np.zeros(len(share))
    for column in mesh.vertices.T:
        squares += (column - np.sum(column * share) / np.sum(share)) ** 2
    base, distances = squares.argmax(), []
    nearest, owner = np.full(len(share), np.inf), np.zeros(len(share), int)
    while len(distances) < min(count, len(share)) and nearest[base] > 0:
        distances.append(search(graph, base))
        owner[distances[-1] < nearest] = len(distances) - 1
        nearest = np.minimum(nearest, distances[-1])
        base = nearest.argmax()
    weights = np.zeros(len(distances))
    np.add.at(weights, owner, share)
    return sum(weight * each for weight, each in zip(weights, distances, strict=True))


def soup(seed, lattice=False):
    """Triangles between few points, in several pieces; on a lattice, many paths are as long."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 40))
    faces = np.array([rng.permutation(count)[:3] for _ in range(count // 2 + 1)], np.int32)
    used = np.unique(faces)
    vertices = rng.integers(0, 3, (count, 3)) if lattice else rng.normal(size=(count, 3))
    if lattice:
        vertices = vertices + np.arange(count)[:, None] // 27 * 3
    return triangulation(
        vertices[used].astype(float), np.searchsorted(used, faces).astype(np.int32)
    )


def grid(size):
    """A flat square of right triangles: most distances occur many times."""
    corners = np.arange(size * size).reshape(size, size)
    a, b, c, d = (
        each.ravel()
        for each in np.broadcast_arrays(
            corners[:-1, :-1], corners[:-1, 1:], corners[1:, :-1], corners[1:, 1:]
        )
    )
    faces = np.concatenate((np.stack((a, b, c), axis=1), np.stack((b, d, c), axis=1)))
    x, y = np.divmod(corners.ravel(), size)
    return triangulation(np.stack((x, y, 0 * x), axis=1).astype(float), faces.astype(np.int32))


@pytest.fixture
def fine(lumpy, triangulate):
    return refine(triangulate(lumpy), 600)


@pytest.mark.parametrize("shortcuts", [False, True])
@pytest.mark.parametrize("count", [1, 7, LANES])
def test_distances_equal_those_of_scipy(fine, shortcuts, count):
    graph, sources = edge_graph(fine, shortcuts), np.arange(count) * 11
    order = order_of(search(graph, 3))
    assert np.array_equal(swept(graph, order, sources), dijkstra(graph, sources))


def test_the_order_of_the_visits_does_not_matter(fine):
    graph, sources = edge_graph(fine, shortcuts=True), np.array([5, 300, 598])
    order = np.random.default_rng(0).permutation(600)
    assert np.array_equal(swept(graph, order, sources), dijkstra(graph, sources))


@pytest.mark.parametrize("seed", range(6))
def test_distances_in_several_pieces_equal_those_of_searches(seed):
    graph = edge_graph(soup(seed), shortcuts=True)
    sources = np.arange(len(graph.starts) - 1)
    expected = np.stack([search(graph, source) for source in sources], axis=1)
    order = order_of(expected[:, 0])
    assert np.array_equal(swept(graph, order, sources), expected)


def test_rows_have_the_edges_of_the_graph(fine):
    graph = edge_graph(fine, shortcuts=True)
    order = np.random.default_rng(1).permutation(600)
    rank = np.argsort(order)
    rows = renumber(graph.starts, graph.neighbors, graph.lengths, order, rank)
    for vertex in range(600):
        old = slice(graph.starts[vertex], graph.starts[vertex + 1])
        place = rank[vertex]
        new = slice(rows.starts[place], rows.starts[place + 1])
        pairs = zip(rank[graph.neighbors[old]], graph.lengths[old], strict=True)
        assert sorted(pairs) == sorted(zip(rows.neighbors[new], rows.lengths[new], strict=True))
        assert (rows.neighbors[rows.starts[place] : rows.middles[place]] < place).all()
        assert (rows.neighbors[rows.middles[place] : rows.starts[place + 1]] > place).all()


def test_an_order_sorts_by_distance_but_for_what_is_nearly_as_far():
    distances = np.random.default_rng(2).random(500)
    distances[[3, 77]] = np.inf
    order = order_of(distances)
    assert sorted(order) == list(range(500))
    assert order[-2:].tolist() == [3, 77]
    assert np.diff(distances[order[:-2]]).min() > -2 / 500


@pytest.mark.parametrize("distances", [[0.0], [0.0, 0.0], [0.0, np.inf], [np.inf, 0.0, np.inf]])
def test_an_order_of_equal_or_unreachable_vertices_has_them_all(distances):
    order = order_of(np.array(distances))
    assert sorted(order) == list(range(len(distances)))
    assert np.array(distances)[order[0]] == 0


def test_weighted_distances_are_added_source_by_source(fine):
    graph, rng = edge_graph(fine, shortcuts=True), np.random.default_rng(3)
    sources, weights = rng.permutation(600)[: 2 * LANES + 3], rng.random(2 * LANES + 3)
    expected = np.zeros(600)
    for source, weight in zip(sources, weights, strict=True):
        expected += weight * search(graph, source)
    arrays = graph.starts, graph.neighbors, graph.lengths
    found = weighted_distances(*arrays, order_of(search(graph, 0)), sources, weights)
    assert np.array_equal(found, expected)


MESHES = {
    **{f"soup {seed}": soup(seed) for seed in range(10)},
    **{f"lattice {seed}": soup(seed, lattice=True) for seed in range(10)},
    "grid": grid(12),
    "triangle": triangulation(np.eye(3), np.array([[0, 1, 2]], np.int32)),
}


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("shortcuts", [False, True])
@pytest.mark.parametrize("name", MESHES)
def test_the_integral_has_the_bits_of_searches_from_each_base(name, shortcuts):
    mesh = MESHES[name]
    graph, areas = edge_graph(mesh, shortcuts), face_areas(mesh)
    for count in (1, 2, 5, 100):
        found = even_integral(graph, mesh.vertices, mesh.faces, areas, count)
        expected = integral_base_by_base(mesh, graph, areas, count)
        assert np.array_equal(found, expected, equal_nan=True)


def test_the_integral_of_a_fine_mesh_has_the_bits_of_searches_from_each_base(fine):
    graph, areas = edge_graph(fine, shortcuts=True), face_areas(fine)
    found = even_integral(graph, fine.vertices, fine.faces, areas, 130)
    assert np.array_equal(found, integral_base_by_base(fine, graph, areas, 130))
