import itertools

import numpy as np
import pandas as pd
import pytest

from egad.evalset.selection import (
    best_of_random,
    candidates_by_cell,
    empty_cells,
    improve,
    mean_distance,
    random_choice,
    select,
    total,
)
from egad.settings import SelectEval, Space
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.objects import OBJECTS

SPACE = Space()
GRID = SelectEval(rows=2, columns=2, restarts=8)


def dataset(count, seed=0, cells=4):
    """Objects in the first of 2 x 2 coarse cells, and symmetric distances between them."""
    rng = np.random.default_rng(seed)
    cell = np.arange(count) % cells
    objects = pd.DataFrame(
        {
            "id": [f"id{number}" for number in range(count)],
            "label": [f"name{number}" for number in range(count)],
            "complexity": np.where(cell % 2, 4.0, 2.0),
            "difficulty": np.where(cell // 2, 0.001, 0.003),
            "complexity_cell": 0,
            "difficulty_cell": 0,
        }
    )
    distances = rng.random((count, count))
    distances += distances.T
    np.fill_diagonal(distances, 0)
    return objects, distances


def chosen_by(objects, distances, settings=GRID, seed=0):
    return select(objects, distances, settings, SPACE, np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(5))
def test_equals_exhaustive_search_on_a_small_set(seed):
    objects, distances = dataset(16, seed)
    cells = [np.arange(16)[np.arange(16) % 4 == cell] for cell in range(4)]
    best = max(total(np.array(each), distances) for each in itertools.product(*cells))
    chosen = chosen_by(objects, distances)
    picked = chosen["id"].str[2:].astype(int).to_numpy()
    assert total(picked, distances) == pytest.approx(best)


def test_no_single_exchange_improves_the_set():
    _, distances = dataset(200, 3)
    cells = [np.flatnonzero(np.arange(200) % 4 == cell) for cell in range(4)]
    found = improve(random_choice(cells, np.random.default_rng(0)), cells, distances)
    for place, cell in enumerate(cells):
        for other in cell:
            exchanged = found.copy()
            exchanged[place] = other
            assert total(exchanged, distances) <= total(found, distances) + 1e-9


def test_labels_rows_and_columns_follow_the_cells():
    chosen = chosen_by(*dataset(40))
    assert list(chosen["label"]) == ["A0", "A1", "B0", "B1"]
    assert (chosen[chosen["row"] == 0]["difficulty"] == 0.003).all()  # easy
    assert (chosen[chosen["column"] == 1]["complexity"] == 4.0).all()
    assert list(chosen.columns) == EVAL49.names


def test_cells_without_objects_stay_empty_and_are_named():
    chosen = chosen_by(*dataset(12, cells=3))
    assert list(chosen["label"]) == ["A0", "A1", "B0"]
    assert empty_cells(chosen, GRID) == ["B1"]


def test_same_seed_same_set():
    objects, distances = dataset(100)
    assert chosen_by(objects, distances).equals(chosen_by(objects, distances))


def test_a_single_object_has_no_nearest():
    chosen = chosen_by(*dataset(1))
    assert len(chosen) == 1
    assert np.isnan(chosen["nearest"][0])


def test_an_empty_dataset_gives_an_empty_set():
    chosen = chosen_by(parquet.empty(OBJECTS), np.zeros((0, 0)))
    assert len(chosen) == 0
    assert empty_cells(chosen, GRID) == ["A0", "A1", "B0", "B1"]


def test_nearest_is_the_smallest_distance_within_the_set():
    objects, distances = dataset(40)
    chosen = chosen_by(objects, distances)
    picked = chosen["id"].str[2:].astype(int).to_numpy()
    for row, index in enumerate(picked):
        others = [other for other in picked if other != index]
        assert chosen["nearest"][row] == pytest.approx(distances[index, others].min())


def test_the_chosen_set_beats_the_best_of_a_thousand_random_ones():
    objects, distances = dataset(200, 1)
    candidates = candidates_by_cell(objects, GRID, SPACE)
    assert sorted(np.concatenate(candidates)) == list(range(200))
    picked = chosen_by(objects, distances)["id"].str[2:].astype(int).to_numpy()
    ours = mean_distance(picked, distances)
    pairs = itertools.combinations(picked, 2)
    assert ours == pytest.approx(np.mean([distances[pair] for pair in pairs]))
    everything = mean_distance(np.arange(200), distances)
    assert ours > best_of_random(candidates, distances, np.random.default_rng(0)) > everything
    assert np.isnan(mean_distance(np.array([3]), distances))
