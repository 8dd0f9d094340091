import heapq

import numpy as np
import pytest
import trimesh

from egad.errors import UserError
from egad.measures.reeb import Forest, Similarity, similarity_matrix
from egad.measures.reeb import graph as reeb
from egad.measures.reeb.forest import space
from egad.measures.reeb.similarity import bound, compare, similarity

SETTINGS = Similarity(vertices=400, ranges=32, base_count=10)
COUNT = 24
PAIRS = [(a, b) for a in range(COUNT) for b in range(a)]


@pytest.fixture(scope="module")
def graphs(spiky_box):
    """Spiky boxes: many branches."""
    return [reeb.extract(spiky_box(number), SETTINGS) for number in range(COUNT)]


@pytest.fixture(scope="module")
def matrix(graphs):
    return similarity_matrix(graphs, 0.5)


class SlowMatcher:
    """The matching as it is told: one heap of the nodes in play, both graphs together."""

    def __init__(self, first, second, weight):
        self.graphs = (first, second)
        self.values = [
            np.stack((g.areas * weight, g.lengths * (1 - weight)), 1) for g in self.graphs
        ]
        self.in_play = [{}, {}]  # node: number of the match of its parent
        self.heap, self.matches, self.total = [], 0, 0.0

    def similarity(self):
        self.enter([[len(graph.areas) - 1] for graph in self.graphs])
        while self.heap:
            _, side, node = heapq.heappop(self.heap)
            if node in self.in_play[side]:
                group = self.in_play[side].pop(node)
                partners = self.best(side, node, group)
                if partners:
                    self.match(side, node, partners)
        return self.total

    def enter(self, nodes):
        for side in (0, 1):
            for node in nodes[side]:
                self.in_play[side][node] = self.matches
                heapq.heappush(self.heap, (-self.values[side][node].sum(), side, node))

    def match(self, side, node, partners):
        both = self.values[side][node], self.values[1 - side][list(partners)].sum(axis=0)
        self.total += np.minimum(*both).sum()
        self.matches += 1
        for partner in partners:
            del self.in_play[1 - side][partner]
        members = [None, None]
        members[side], members[1 - side] = [node], partners
        self.enter([[c for m in members[s] for c in self.row(s, m, "child")] for s in (0, 1)])

    def best(self, side, node, group):
        graph, other = self.graphs[side], self.graphs[1 - side]
        level = np.searchsorted(graph.level_starts, node, side="right")
        rivals = [
            rival
            for rival, number in self.in_play[1 - side].items()
            if number == group
            and np.searchsorted(other.level_starts, rival, side="right") == level
            and other.ranges[rival] == graph.ranges[node]
        ]
        choices = [(rival,) for rival in rivals] + self.runs(1 - side, rivals)[:64]
        costs = [self.cost(side, node, choice) for choice in choices]
        return choices[np.argmin(costs)] if choices else None

    def runs(self, side, rivals):
        found, seen = [], set()
        for rival in rivals:
            for neighbor in self.row(side, rival, "neighbor"):
                if neighbor not in seen:
                    seen.add(neighbor)
                    line = [n for n in self.row(side, neighbor, "neighbor") if n in rivals]
                    for start in range(len(line)):
                        ends = range(start + 2, min(start + 5, len(line)) + 1)
                        found += [tuple(line[start:end]) for end in ends]
        return found

    def cost(self, side, node, partners):
        cost = self.loss(side, [node], partners)
        for step in (-1, 1):
            around = [self.around(side, [node], step), self.around(1 - side, partners, step)]
            cost += 0.1 * self.loss(side, *around)
        return cost

    def loss(self, side, nodes, others):
        both = self.values[side][list(nodes)].sum(0), self.values[1 - side][list(others)].sum(0)
        return (both[0].sum() + both[1].sum()) / 2 - np.minimum(*both).sum()

    def around(self, side, nodes, step):
        ranges = self.graphs[side].ranges
        near = {n: m for m in nodes for n in self.row(side, m, "neighbor")}
        return [n for n, m in near.items() if ranges[n] == ranges[m] + step]

    def row(self, side, node, kind):
        graph = self.graphs[side]
        items = graph.children if kind == "child" else graph.neighbors
        starts = graph.child_starts if kind == "child" else graph.neighbor_starts
        return items[starts[node] : starts[node + 1]].tolist()


@pytest.mark.parametrize("weight", [0.5, 0.2])
def test_matching_equals_the_slow_one(graphs, weight):
    for a, b in PAIRS[::3]:
        either = [
            SlowMatcher(*pair, weight).similarity()
            for pair in ((graphs[a], graphs[b]), (graphs[b], graphs[a]))
        ]
        found = similarity(graphs[a], graphs[b], weight)
        assert min(abs(found - value) for value in either) < 1e-12


def test_some_nodes_are_matched_to_runs(graphs, monkeypatch):
    monkeypatch.setattr(SlowMatcher, "runs", lambda *_: [])
    without = [SlowMatcher(graphs[a], graphs[b], 0.5).similarity() for a, b in PAIRS[:20]]
    found = [similarity(graphs[a], graphs[b], 0.5) for a, b in PAIRS[:20]]
    assert np.mean(found) > np.mean(without) + 0.005


def test_similarity_is_symmetric_and_between_0_and_1(graphs, matrix):
    assert np.array_equal(matrix, matrix.T)
    assert (matrix.diagonal() == 1).all()
    off = matrix[np.tril_indices(COUNT, -1)]
    assert off.min() > 0
    assert off.max() < 1
    for a, b in PAIRS[::20]:
        assert similarity(graphs[a], graphs[b], 0.5) == matrix[a, b]
        assert similarity(graphs[b], graphs[a], 0.5) == matrix[a, b]


@pytest.mark.parametrize("weight", [0.0, 0.5, 1.0])
def test_a_shape_matches_all_of_itself(graphs, weight):
    for graph in graphs:
        assert SlowMatcher(graph, graph, weight).similarity() == pytest.approx(1)
        assert similarity(graph, graph, weight) == 1


def test_a_copy_of_other_bytes_matches_nearly_all(graphs):
    for graph in graphs:
        values = {"areas": graph.areas * (1 + 1e-9), "lengths": graph.lengths * (1 - 1e-9)}
        copy = reeb.ReebGraph(**{**vars(graph), **values})
        assert similarity(graph, copy, 0.5) == pytest.approx(1, abs=1e-6)


def test_the_bound_holds(graphs, matrix):
    profiles = Forest(0.5, graphs).trees.profiles
    bounds = np.array([bound(profiles, a, b) for a, b in PAIRS])
    slack = bounds - [matrix[pair] for pair in PAIRS]
    assert slack.min() > -1e-12
    assert slack.mean() < 0.2


def test_comparing_up_to_a_least_value(graphs, matrix):
    trees, memory, early = Forest(0.5, graphs).trees, space(np.array([0, 10_000], np.int32)), 0
    for pair in PAIRS:
        exact = matrix[pair]
        for least in (exact - 0.01, exact - 1e-9, exact + 1e-9, exact + 0.01, 1.0):
            value, complete = compare(trees, *pair, least, memory)
            if complete:
                assert value == exact
            else:
                assert exact - 1e-12 < value < least
                early += 1
    assert early > len(PAIRS)


def test_graphs_of_other_resolution_are_refused(graphs):
    coarse = reeb.extract(trimesh.creation.box(), SETTINGS.model_copy(update={"ranges": 16}))
    with pytest.raises(UserError, match="ranges"):
        similarity(graphs[0], coarse, 0.5)
    forest = Forest(0.5, graphs[:2])
    with pytest.raises(UserError):
        forest.extend([graphs[2], coarse])
    assert len(forest) == 2


def test_a_forest_that_grew_equals_one_made_at_once(graphs):
    grown = Forest(0.5)
    for graph in graphs:
        grown.extend([graph])
    for one, other in zip(grown.trees.nodes, Forest(0.5, graphs).trees.nodes, strict=True):
        assert np.array_equal(one, other)


def test_no_graphs():
    assert similarity_matrix([], 0.5).shape == (0, 0)
