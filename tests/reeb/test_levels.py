import networkx as nx
import numpy as np
import pytest

from egad.reeb.graph import ReebGraph, levels
from egad.reeb.ranges import Parts


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
def test_neighbours_are_the_parts_that_touch(graph, finest, level):
    found = members(graph, level)
    owner = {node: top for top, part in found.items() for node in part}
    expected = {top: set() for top in found}
    for a, b in finest.links.tolist():
        if graph.ranges[owner[a]] != graph.ranges[owner[b]]:
            expected[owner[a]].add(owner[b])
            expected[owner[b]].add(owner[a])
    for node in found:
        row = graph.neighbours[graph.neighbour_starts[node] : graph.neighbour_starts[node + 1]]
        assert row.tolist() == sorted(expected[node])


def test_children_are_those_that_name_their_parent(graph):
    for node in range(len(graph.ranges)):
        row = graph.children[graph.child_starts[node] : graph.child_starts[node + 1]]
        assert row.tolist() == np.flatnonzero(graph.parents == node).tolist()


def test_nodes_are_sorted_by_level_then_range(graph):
    for start, end in zip(graph.level_starts, graph.level_starts[1:], strict=False):
        assert (np.diff(graph.ranges[start:end]) >= 0).all()
