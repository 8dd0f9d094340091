import numpy as np
import pytest
import trimesh

from egad.errors import UserError
from egad.measures.reeb import Neighborhood, Similarity, diversities, neighbors, similarity_matrix
from egad.measures.reeb import graph as reeb

SETTINGS = Similarity(vertices=200, ranges=16, base_count=10)


@pytest.fixture(scope="module")
def graphs(spiky_box):
    return [reeb.extract(spiky_box(number), SETTINGS) for number in range(40)]


@pytest.fixture(scope="module")
def distances(graphs):
    return 1 - similarity_matrix(graphs, 0.5)


def test_nearest_equals_the_exhaustive_search(graphs, distances):
    everyone = Neighborhood(0.5, 5)
    for index in everyone.add(graphs):
        found, values = everyone.nearest(index)
        others = np.delete(np.arange(40), index)
        expected = others[np.lexsort((others, distances[index, others]))][:5]
        assert np.array_equal(found, expected)
        assert np.array_equal(values, distances[index, expected])


def test_a_set_that_changes_equals_one_made_anew(graphs, monkeypatch):
    monkeypatch.setattr(neighbors, "SPARE", 0)  # plants the forest anew all the time
    changing = Neighborhood(0.5, 4)
    places = dict(zip(range(20), changing.add(graphs[:20]), strict=True))
    rng = np.random.default_rng(0)
    for step in range(10):
        for number in rng.choice(list(places), 6, replace=False):
            changing.diversity(places[number])
            changing.remove(places.pop(number))
        fresh = [number for number in range(40) if number not in places][step : step + 6]
        added = changing.add([graphs[number] for number in fresh])
        places |= dict(zip(fresh, added, strict=True))
        members = sorted(places)
        expected = diversities([graphs[number] for number in members], 0.5, 4)
        assert [changing.diversity(places[number]) for number in members] == expected.tolist()


def test_many_distances_are_never_computed(graphs):
    everyone = Neighborhood(0.5, 2)
    for index in everyone.add(graphs):
        everyone.diversity(index)
    exact = everyone._known[np.triu_indices(40, 1)] == neighbors._EXACT
    assert 40 < exact.sum() < 0.7 * len(exact)


def test_the_order_of_questions_does_not_matter(graphs):
    forwards, backwards = Neighborhood(0.5, 3), Neighborhood(0.5, 3)
    places = forwards.add(graphs)
    backwards.add(graphs)
    one = [forwards.diversity(index) for index in places]
    other = [backwards.diversity(index) for index in reversed(places)]
    assert one == other[::-1]


def test_any_number_of_threads_finds_the_same(graphs, monkeypatch):
    monkeypatch.setattr(neighbors, "CHUNK", 1)
    monkeypatch.setattr(neighbors, "ROUND", 3)
    expected = diversities(graphs, 0.5, 4).tolist()
    for threads in (2, 5):
        assert diversities(graphs, 0.5, 4, threads).tolist() == expected
        changing = Neighborhood(0.5, 4, threads)
        places = changing.add(graphs)
        changing.diversities(places[:7])
        gone = changing.diversities(places)
        changing.remove(places[20])
        changing.add(graphs[20:21])
        assert changing.diversities(places) == gone == expected


def test_removing_one_of_many_can_only_raise_a_diversity(graphs):
    everyone = Neighborhood(0.5, 3)
    before = dict(enumerate(everyone.diversities(everyone.add(graphs))))
    popular = everyone.nearest(0)[0][0].item()
    everyone.remove(popular)
    others = sorted(before.keys() - {popular})
    after = dict(zip(others, everyone.diversities(others), strict=True))
    assert all(after[index] >= before[index] for index in others)
    assert after != {index: before[index] for index in others}


def test_few_members(graphs):
    lonely = Neighborhood(0.5, 10)
    (only,) = lonely.add(graphs[:1])
    assert lonely.diversity(only) == 1.0
    lonely.add(graphs[1:3])
    assert len(lonely.nearest(only)[0]) == 2
    assert len(diversities([], 0.5, 10)) == 0


def test_a_pair_given_up_early_gets_its_exact_distance_when_asked(graphs, distances):
    everyone = Neighborhood(0.5, 1)
    for index in everyone.add(graphs):
        everyone.nearest(index)
    found = [[everyone.distance(a, b) for b in range(40)] for a in range(40)]
    assert np.array_equal(found, distances)


def test_equal_shapes_are_at_distance_0_and_sorted_by_index(graphs):
    twins = Neighborhood(0.5, 3)
    twins.add([graphs[0], graphs[1], graphs[0], graphs[0]])
    indices, values = twins.nearest(2)
    assert indices.tolist() == [0, 3, 1]
    assert values[:2].tolist() == [0, 0]
    assert twins.distance(2, 2) == 0


def test_unknown_members(graphs):
    pair = Neighborhood(0.5, 3)
    pair.add(graphs[:2])
    pair.remove(0)
    assert len(pair) == 1
    for question in (pair.diversity, pair.nearest, pair.remove, lambda i: pair.distance(1, i)):
        for index in (0, 2, -1):
            with pytest.raises(KeyError):
                question(index)
    assert pair.diversity(1) == 1.0


def test_other_resolutions_are_refused_and_nothing_is_lost(graphs):
    coarse = SETTINGS.model_copy(update={"ranges": 32})
    few = Neighborhood(0.5, 3)
    few.add(graphs[:2])
    with pytest.raises(UserError):
        few.add([graphs[2], reeb.extract(trimesh.creation.box(), coarse)])
    assert few.add(graphs[2:3]) == [2]
    assert few.diversity(2) == diversities(graphs[:3], 0.5, 3)[2]
