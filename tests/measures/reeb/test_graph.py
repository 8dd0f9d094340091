import dataclasses
import struct
import zlib
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
import trimesh
from scipy.stats import spearmanr

from egad.errors import RejectedError, UserError
from egad.measures.reeb import Similarity, similarity_matrix
from egad.measures.reeb import graph as reeb
from egad.measures.reeb.graph import ReebGraph, levels
from egad.measures.reeb.ranges import Parts
from egad.measures.reeb.similarity import similarity

REFERENCE = Path(__file__).parents[2] / "data" / "reeb_reference.npz"
BOX = trimesh.creation.box().subdivide()
QUICK = Similarity(vertices=300, ranges=16, base_count=10)
PAIRS = np.triu_indices(8, 1)


@pytest.fixture(scope="module")
def shapes():
    """Eight evolved shapes, metres, at most 2500 vertices."""
    with np.load(REFERENCE) as data:
        return [
            raw(data[name], data[name.replace("vertices", "faces")])
            for name in data.files
            if name.startswith("vertices")
        ]


@pytest.fixture(scope="module")
def published():
    """Similarities of these shapes by the program that the published values come from."""
    with np.load(REFERENCE) as data:
        return data["similarity"][PAIRS]


@pytest.fixture(scope="module")
def graphs(shapes):
    return [reeb.extract(mesh, Similarity()) for mesh in shapes]


def raw(vertices, faces):
    return trimesh.Trimesh(vertices, faces, process=False, validate=False)


def fields(graph):
    return [getattr(graph, field.name) for field in dataclasses.fields(graph)]


def moved(mesh, transform):
    result = mesh.copy()
    result.vertices = transform(np.asarray(mesh.vertices, float))
    return result


def test_scan_agrees_with_the_published_program(shapes, published):
    graphs = [reeb.extract(mesh, Similarity(bases="scan")) for mesh in shapes]
    found = similarity_matrix(graphs, 0.5)[PAIRS]
    assert spearmanr(found, published)[0] >= 0.95
    assert np.abs(found - published).mean() <= 0.02


def test_a_few_even_bases_are_nearly_as_good_as_all_vertices(shapes):
    def similarities(count):
        graphs = [reeb.extract(mesh, Similarity(base_count=count)) for mesh in shapes]
        return similarity_matrix(graphs, 0.5)[PAIRS]

    ideal = similarities(10**6)
    for count in (50, 75):
        found = similarities(count)
        assert spearmanr(found, ideal)[0] >= 0.99
        assert np.abs(found - ideal).mean() <= 0.011


def test_order_place_size_and_orientation_do_not_matter(shapes, graphs):
    rng = np.random.default_rng(0)
    for mesh, graph in zip(shapes[:4], graphs[:4], strict=True):
        order = rng.permutation(len(mesh.vertices))
        faces = rng.permutation(np.argsort(order)[mesh.faces])
        turn = trimesh.transformations.random_rotation_matrix(rng.random(3))[:3, :3]
        copies = [
            raw(mesh.vertices[order], faces),
            moved(mesh, lambda v, turn=turn: v @ turn.T),
            moved(mesh, lambda v: v + np.array([3, -1, 2])),
            moved(mesh, lambda v: v * 1000),
            moved(mesh, lambda v: v * [1, 1, -1]),
        ]
        for copy in copies:
            assert similarity(graph, reeb.extract(copy, Similarity()), 0.5) >= 0.99


def test_another_mesh_of_the_same_shape_is_much_the_same(shapes, graphs):
    for mesh, graph in zip(shapes, graphs, strict=True):
        finer = mesh.subdivide()
        assert similarity(graph, reeb.extract(finer, Similarity()), 0.5) >= 0.9


def test_areas_and_lengths_sum_to_one(graphs):
    for graph in graphs:
        assert len(graph.level_starts) == 9
        for values in (graph.areas, graph.lengths):
            levels = np.add.reduceat(values, graph.level_starts[:-1])
            assert levels == pytest.approx(np.full(8, 1 / 8))
            assert (values >= 0).all()


def test_the_same_mesh_gives_the_same_bytes(shapes, graphs):
    again = reeb.extract(shapes[0].copy(), Similarity())
    assert reeb.pack(again) == reeb.pack(graphs[0])


def test_packing_keeps_every_bit(graphs):
    for graph in graphs:
        again = reeb.unpack(reeb.pack(graph))
        for one, other in zip(fields(graph), fields(again), strict=True):
            assert one.dtype == other.dtype
            assert np.array_equal(one, other)


def test_damaged_bytes_are_refused(graphs):
    data = reeb.pack(graphs[0])
    for length in (0, 3, 10, len(data) // 2, len(data) - 1):
        with pytest.raises(UserError):
            reeb.unpack(data[:length])
    with pytest.raises(UserError):
        reeb.unpack(data + b"\0")
    for place in np.random.default_rng(0).integers(0, len(data), 50):
        wrong = bytearray(data)
        wrong[place] ^= 1
        with pytest.raises(UserError):
            reeb.unpack(bytes(wrong))


@pytest.mark.parametrize("damage", ["range", "node", "negative", "counts"])
def test_bytes_with_a_right_checksum_that_name_what_is_not_there_are_refused(graphs, damage):
    """Compiled code would read beyond its arrays."""
    data = bytearray(reeb.pack(graphs[0])[:-4])
    nodes, _ = struct.unpack_from("<II", data, 8)
    place = 16 + 16 * nodes
    if damage == "counts":
        struct.pack_into("<I", data, 12, 1 << 30)
    elif damage == "node":
        struct.pack_into("<i", data, len(data) - 4, nodes)
    else:
        struct.pack_into("<i", data, place, 10_000 if damage == "range" else -1)
    with pytest.raises(UserError):
        reeb.unpack(bytes(data) + struct.pack("<I", zlib.crc32(data)))


@pytest.mark.parametrize("bases", ["even", "scan"])
@pytest.mark.parametrize(
    "mesh",
    [
        raw(BOX.vertices, BOX.faces[4:]),
        raw([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
        BOX.subdivide(),
        trimesh.creation.torus(1, 0.4, major_sections=12, minor_sections=6),
        trimesh.creation.cylinder(0.001, 1),
    ],
    ids=["open", "triangle", "box", "torus", "needle"],
)
def test_unusual_meshes_are_measured(mesh, bases):
    graph = reeb.extract(mesh, QUICK.model_copy(update={"bases": bases}))
    assert graph.areas.sum() == pytest.approx(1)
    assert similarity(graph, graph, 0.5) == 1


def test_useless_faces_and_vertices_do_not_matter():
    faces = np.concatenate((BOX.faces, [[3, 3, 5], [4, 4, 4]]))
    untidy = raw(np.concatenate((BOX.vertices, [[9, 9, 9]])), faces)
    assert reeb.pack(reeb.extract(untidy, QUICK)) == reeb.pack(reeb.extract(BOX, QUICK))


def test_walls_of_cavities_do_not_matter():
    hole = trimesh.creation.icosphere(1, radius=0.2)
    hole.invert()
    hollow = trimesh.util.concatenate([hole, BOX])
    assert reeb.pack(reeb.extract(hollow, QUICK)) == reeb.pack(reeb.extract(BOX, QUICK))
    hollow.invert()
    assert similarity(reeb.extract(hollow, QUICK), reeb.extract(BOX, QUICK), 0.5) > 0.99


def cubes(*places):
    boxes = [
        trimesh.creation.box(transform=trimesh.transformations.translation_matrix(p))
        for p in places
    ]
    return trimesh.util.concatenate(boxes)


NOTHING = np.empty((0, 3))
BAD = {
    "no mesh": (trimesh.Trimesh(), "no faces"),
    "no faces": (raw([[0, 0, 0], [1, 0, 0]], NOTHING), "no faces"),
    "line": (raw([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]), "area"),
    "point": (raw(np.ones((3, 3)), [[0, 1, 2]]), "extent"),
    "nan": (raw([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]]), "finite"),
    "two cubes": (cubes([0, 0, 0], [2, 0, 0]), "one connected piece"),
    "cube in a cube": (cubes([0, 0, 0], [0.1, 0, 0]), "one connected piece"),
}


@pytest.mark.parametrize(("mesh", "reason"), BAD.values(), ids=BAD.keys())
def test_useless_meshes_are_rejected_with_the_reason(mesh, reason):
    with pytest.raises(RejectedError, match=reason):
        reeb.extract(mesh, QUICK)


@pytest.fixture(scope="module")
def finest():
    """A random graph over 16 ranges with several parts each."""
    rng = np.random.default_rng(1)
    ranges = np.sort(np.concatenate([np.arange(16), rng.integers(0, 16, 40)])).astype(np.int32)
    pairs = [(a, b) for a in range(56) for b in range(56) if ranges[b] == ranges[a] + 1]
    links = np.array([pair for pair in pairs if rng.random() < 0.4], np.int32)
    return Parts(ranges, rng.random(56), rng.random(56), links)


@pytest.fixture(scope="module")
def graph(finest):
    return ReebGraph(*levels(finest, 5))


def members(graph, level):
    """The nodes of a level as sets of nodes of the finest one."""
    sets = {}
    for node in range(graph.level_starts[1]):
        top = node
        for _ in range(level):
            top = graph.parents[top]
        sets.setdefault(int(top), set()).add(node)
    return sets


def test_the_finest_level_is_what_was_given(graph, finest):
    assert np.array_equal(graph.ranges[:56], finest.ranges)
    assert np.array_equal(graph.areas[:56], finest.areas)
    assert np.array_equal(graph.lengths[:56], finest.lengths)


@pytest.mark.parametrize("level", range(5))
def test_a_node_is_a_connected_union_of_finest_ones(graph, finest, level):
    coarse = finest.ranges // 2**level
    whole = nx.Graph()
    whole.add_nodes_from(range(56))
    whole.add_edges_from((a, b) for a, b in finest.links.tolist() if coarse[a] == coarse[b])
    expected = {frozenset(part) for part in nx.connected_components(whole)}
    found = members(graph, level)
    assert set(found) == set(range(graph.level_starts[level], graph.level_starts[level + 1]))
    assert {frozenset(part) for part in found.values()} == expected
    for node, part in found.items():
        assert set(coarse[list(part)]) == {graph.ranges[node]}
        assert graph.areas[node] == pytest.approx(finest.areas[list(part)].sum())
        assert graph.lengths[node] == pytest.approx(finest.lengths[list(part)].sum())


@pytest.mark.parametrize("level", range(5))
def test_neighbors_are_the_parts_that_touch(graph, finest, level):
    found = members(graph, level)
    owner = {node: top for top, part in found.items() for node in part}
    expected = {top: set() for top in found}
    for a, b in finest.links.tolist():
        if graph.ranges[owner[a]] != graph.ranges[owner[b]]:
            expected[owner[a]].add(owner[b])
            expected[owner[b]].add(owner[a])
    for node in found:
        row = graph.neighbors[graph.neighbor_starts[node] : graph.neighbor_starts[node + 1]]
        assert row.tolist() == sorted(expected[node])


def test_children_are_those_that_name_their_parent(graph):
    for node in range(len(graph.ranges)):
        row = graph.children[graph.child_starts[node] : graph.child_starts[node + 1]]
        assert row.tolist() == np.flatnonzero(graph.parents == node).tolist()


def test_nodes_are_sorted_by_level_then_range(graph):
    for start, end in zip(graph.level_starts, graph.level_starts[1:], strict=False):
        assert (np.diff(graph.ranges[start:end]) >= 0).all()
