import numpy as np
import pytest

import egad
from egad.cli.released_graphs import dataset_graphs
from egad.data import released_graphs
from egad.measures.reeb import Similarity
from egad.measures.reeb import graph as reeb
from egad.tables import parquet
from egad.tables.objects import GRAPHS


@pytest.fixture(scope="module")
def objects():
    return egad.load("released")


def unused(*_):
    raise AssertionError("a graph is extracted")


def test_the_shipped_graphs_are_of_all_released_objects(objects):
    table = parquet.read(released_graphs(), GRAPHS)
    assert table["id"].tolist() == objects.table["id"].tolist()


def test_the_shipped_graphs_are_those_of_the_meshes(objects):
    """If not, run `python -m egad.cli.released_graphs`."""
    some = objects.select(objects.table["label"].sample(8, random_state=61))
    shipped = dataset_graphs(some, Similarity(), unused)
    made = dataset_graphs(some, Similarity(), map, shipped=False)
    for one, other in zip(map(reeb.unpack, shipped), map(reeb.unpack, made), strict=True):
        assert np.array_equal(one.ranges, other.ranges)
        assert np.array_equal(one.neighbors, other.neighbors)
        assert one.areas == pytest.approx(other.areas, rel=1e-6)
        assert one.lengths == pytest.approx(other.lengths, rel=1e-6)


def test_with_other_settings_graphs_are_made(objects):
    one = objects.select("M14_3")
    with pytest.raises(AssertionError, match="is extracted"):
        dataset_graphs(one, Similarity(ranges=64), unused)
    (graph,) = dataset_graphs(one, Similarity(ranges=64), map)
    assert len(reeb.unpack(graph).level_starts) == 8
