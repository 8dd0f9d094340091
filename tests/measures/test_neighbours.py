import numpy as np
import pytest
import trimesh

from egad.measures import neighbours, reeb
from egad.measures.neighbours import Neighbourhood, diversities
from egad.measures.similarity import similarity_matrix
from egad.settings import Similarity

SETTINGS = Similarity(vertices=200, ranges=16, base_count=10)


@pytest.fixture(scope="module")
def graphs():
    shapes = []
    for number in range(40):
        rng = np.random.default_rng(number)
        mesh = trimesh.creation.box(extents=rng.uniform(0.2, 1, 3)).subdivide().subdivide()
        mesh.vertices[rng.random(len(mesh.vertices)) < 0.3] *= rng.uniform(0.6, 1.5)
        shapes.append(reeb.extract(mesh, SETTINGS))
    return shapes


@pytest.fixture(scope="module")
def distances(graphs):
    return 1 - similarity_matrix(graphs, 0.5)


def test_nearest_equals_the_exhaustive_search(graphs, distances):
    everyone = Neighbourhood(0.5, 5)
    for index in everyone.add(graphs):
        found, values = everyone.nearest(index)
        others = np.delete(np.arange(40), index)
        expected = others[np.lexsort((others, distances[index, others]))][:5]
        assert np.array_equal(found, expected)
        assert np.array_equal(values, distances[index, expected])


def test_a_set_that_changes_equals_one_made_anew(graphs, monkeypatch):
    monkeypatch.setattr(neighbours, "SPARE", 0)  # plants the forest anew all the time
    changing = Neighbourhood(0.5, 4)
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


def test_no_distance_is_computed_twice_and_many_not_at_all(graphs, monkeypatch):
    asked = []
    original = neighbours.similarities

    def counting(forest, pairs):
        asked.extend(map(tuple, np.sort(pairs, axis=1).tolist()))
        return original(forest, pairs)

    monkeypatch.setattr(neighbours, "similarities", counting)
    everyone = Neighbourhood(0.5, 2)
    for _ in range(2):
        for index in everyone.add(graphs) if not asked else range(40):
            everyone.diversity(index)
    assert len(asked) == len(set(asked))
    assert len(asked) < 40 * 39 / 2


def test_the_order_of_questions_does_not_matter(graphs):
    forwards, backwards = Neighbourhood(0.5, 3), Neighbourhood(0.5, 3)
    places = forwards.add(graphs)
    backwards.add(graphs)
    one = [forwards.diversity(index) for index in places]
    other = [backwards.diversity(index) for index in reversed(places)]
    assert one == other[::-1]


def test_distance_is_symmetric(graphs, distances):
    two = Neighbourhood(0.5, 1)
    a, b = two.add(graphs[:2])
    assert two.distance(a, b) == two.distance(b, a) == distances[0, 1]


def test_few_members(graphs):
    lonely = Neighbourhood(0.5, 10)
    (only,) = lonely.add(graphs[:1])
    assert lonely.diversity(only) == 1.0
    lonely.add(graphs[1:3])
    assert len(lonely.nearest(only)[0]) == 2
    assert len(diversities([], 0.5, 10)) == 0
