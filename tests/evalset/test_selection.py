import itertools

import numpy as np
import pandas as pd
import pytest

from egad.evalset import SelectEval
from egad.evalset.selection import (
    LABEL,
    best_of_random,
    bound,
    candidates_by_cell,
    cell_of_label,
    coarse_cells,
    empty_cells,
    improve,
    label_at,
    labels_of,
    mean_distance,
    random_choice,
    select,
    total,
)
from egad.measures import MeasureSpace
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.objects import OBJECTS

SPACE = MeasureSpace()
GRID = SelectEval(rows=2, columns=2)


def dataset(count, seed=0, cells=4):
    """Objects in the first of 2 x 2 coarse cells, and symmetric distances between them."""
    rng = np.random.default_rng(seed)
    cell = np.arange(count) % cells
    objects = pd.DataFrame(
        {
            "id": [f"id{number}" for number in range(count)],
            "label": [f"name{number}" for number in range(count)],
            "complexity": np.where(cell % 2, 4.0, 2.0),
            "graspability": np.where(cell // 2, 0.001, 0.003),
            "complexity_cell": 0,
            "difficulty_cell": 0,
            "cell_confidence": 1.0,
        }
    )
    distances = rng.random((count, count))
    distances += distances.T
    np.fill_diagonal(distances, 0)
    return objects, distances


def chosen_by(objects, distances, settings=GRID, seed=0):
    return selected(objects, distances, settings=settings, seed=seed).table


def selected(objects, distances, problems=None, settings=GRID, seed=0):
    rng = np.random.default_rng(seed)
    return select(objects, distances, settings, SPACE, rng, problems)


def test_certain_objects_come_before_others_of_their_cell():
    objects, _ = dataset(16)
    objects.loc[[0, 4, 8, 1, 5, 9, 13], "cell_confidence"] = [0.5, 0.989, 0.99, 0.1, 0.2, 0.3, 0.4]
    found = candidates_by_cell(objects, GRID, SPACE)
    assert [rows.tolist() for rows in found.values()] == [
        [8, 12],  # the certain ones
        [1, 5, 9, 13],  # none is certain
        [2, 6, 10, 14],
        [3, 7, 11, 15],
    ]
    assert candidates_by_cell(objects, GRID, SPACE, [8, 12])[0].tolist() == [0, 4]


@pytest.mark.parametrize("seed", range(5))
def test_equals_exhaustive_search_on_a_small_set(seed):
    objects, distances = dataset(16, seed)
    cells = [np.arange(16)[np.arange(16) % 4 == cell] for cell in range(4)]
    best = max(total(np.array(each), distances) for each in itertools.product(*cells))
    chosen = chosen_by(objects, distances)
    picked = chosen["id"].str[2:].astype(int).to_numpy()
    assert total(picked, distances) == pytest.approx(best)


def test_labels_rows_and_columns_follow_the_cells():
    chosen = chosen_by(*dataset(40))
    assert list(chosen["label"]) == ["A0", "A1", "B0", "B1"]
    assert (chosen[chosen["row"] == 0]["graspability"] == 0.003).all()  # easy
    assert (chosen[chosen["column"] == 1]["complexity"] == 4.0).all()
    assert list(chosen.columns) == EVAL49.names


def test_cells_without_objects_stay_empty_and_are_named():
    chosen = chosen_by(*dataset(12, cells=3))
    assert list(chosen["label"]) == ["A0", "A1", "B0"]
    assert empty_cells(chosen, GRID) == ["B1"]


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
    candidates = list(candidates_by_cell(objects, GRID, SPACE).values())
    assert sorted(np.concatenate(candidates)) == list(range(200))
    picked = chosen_by(objects, distances)["id"].str[2:].astype(int).to_numpy()
    ours = mean_distance(picked, distances)
    pairs = itertools.combinations(picked, 2)
    assert ours == pytest.approx(np.mean([distances[pair] for pair in pairs]))
    everything = mean_distance(np.arange(200), distances)
    assert ours > best_of_random(candidates, distances, np.random.default_rng(0)) > everything
    assert np.isnan(mean_distance(np.array([3]), distances))


@pytest.mark.parametrize("seed", range(5))
def test_one_start_and_pair_exchanges_come_close_to_the_optimum_and_below_the_bound(seed):
    _, distances = dataset(30, seed)
    cells = [np.flatnonzero(np.arange(30) % 6 == cell) for cell in range(6)]
    best = max(mean_distance(np.array(each), distances) for each in itertools.product(*cells))
    found = improve(random_choice(cells, np.random.default_rng(seed)), cells, distances)
    assert 0.97 * best <= mean_distance(found, distances) <= best + 1e-12
    assert best <= bound(cells, distances)


@pytest.mark.parametrize("seed", range(5))
def test_exchanges_are_the_first_that_single_steps_find(seed):
    """A slow twin: pair after pair, and of each all objects one by one."""
    _, distances = dataset(40, seed)
    cells = [np.flatnonzero(np.arange(40) % 7 == cell) for cell in (3, 0, 1, 6, 2)]
    start = random_choice(cells, np.random.default_rng(seed))
    expected = improved_singly(start, cells, distances)
    while (better := first_better_pair(expected, cells, distances)) is not None:
        expected = improved_singly(better, cells, distances)
    assert list(improve(start, cells, distances)) == list(expected)


def improved_singly(chosen, cells, distances):
    best = None
    while best is None or total(best, distances) < total(chosen, distances) - 1e-12:
        best = chosen.copy()
        for slot, cell in enumerate(cells):
            sets = [np.array([*chosen[:slot], each, *chosen[slot + 1 :]]) for each in cell]
            chosen = max(sets, key=lambda each: total(each, distances))
    return chosen


def first_better_pair(chosen, cells, distances):
    for first, second in itertools.combinations(range(len(cells)), 2):
        sets = []
        for one, other in itertools.product(cells[first], cells[second]):
            sets.append(chosen.copy())
            sets[-1][[first, second]] = one, other
        best = max(sets, key=lambda each: total(each, distances))
        if total(best, distances) > total(chosen, distances) + 1e-9:
            return best
    return None


def test_only_objects_without_problems_are_chosen():
    """The best set among the objects that pass, though only those that were chosen are checked."""
    objects, distances = dataset(24, 5)
    looked_at = []

    def odd_ones_fail(cell_of_label):
        looked_at.append(cell_of_label)
        return ["too thin"] if cell_of_label % 8 < 4 else []

    found = selected(objects, distances, odd_ones_fail)
    good = [np.flatnonzero((np.arange(24) % 4 == c) & (np.arange(24) % 8 >= 4)) for c in range(4)]
    best = max(total(np.array(each), distances) for each in itertools.product(*good))
    assert total(found.chosen, distances) == pytest.approx(best)
    assert all(cell_of_label % 8 < 4 for cell_of_label in found.left_out)
    assert len(looked_at) == len(set(looked_at))


def test_a_cell_whose_objects_all_have_problems_is_empty():
    found = selected(
        *dataset(12), lambda cell_of_label: ["too thin"] if cell_of_label % 4 == 0 else []
    )
    assert list(found.table["label"]) == ["A1", "B0", "B1"]
    assert sorted(found.left_out) == [0, 4, 8]


BORROWING = SelectEval(rows=2, columns=2, borrow=0.1)
ROW, COLUMN = 0.00175, 2.0  # height and width of a cell


def objects(*places):
    """Objects at rows and columns: (0.5, 1.5) is the middle of the second cell."""
    rows, columns = np.array(places, dtype=float).reshape(-1, 2).T
    measures = {"graspability": 0.004 - rows * ROW, "complexity": 1 + columns * COLUMN}
    return pd.DataFrame({**measures, "cell_confidence": 1.0})


def found(table, left_out=()):
    cells = candidates_by_cell(table, BORROWING, SPACE, left_out)
    return {cell: members.tolist() for cell, members in cells.items()}


def test_every_object_stands_for_its_own_cell():
    table = objects(*np.random.default_rng(0).random((100, 2)) * 2)
    cells = found(table)
    assert sorted(itertools.chain(*cells.values())) == list(range(100))
    own = coarse_cells(table, BORROWING, SPACE)
    assert all((own[members] == cell).all() for cell, members in cells.items())


def test_an_empty_cell_borrows_the_nearest_object_beside_it():
    table = objects((0.5, 0.5), (1.05, 0.5), (1.02, 0.5), (1.5, 0.5), (1.5, 1.5))
    assert found(table) == {0: [0], 2: [1, 2, 3], 3: [4]}  # nothing is near the second
    lonely = objects((1.05, 0.5), (1.02, 0.5), (1.5, 0.5), (1.5, 1.5))
    assert found(lonely) == {0: [1], 2: [0, 2], 3: [3]}
    assert found(lonely, left_out=[1]) == {0: [0], 2: [2], 3: [3]}
    assert found(lonely, left_out=[0, 1]) == {2: [2], 3: [3]}


def test_there_may_be_more_columns_than_rows():
    table = objects((0.5, 0.975), (0.5, 0.75), (0.5, 1.75))  # columns are half as wide
    wide = SelectEval(rows=2, columns=4, borrow=0.1)
    cells = {k: v.tolist() for k, v in candidates_by_cell(table, wide, SPACE).items()}
    assert cells == {1: [1], 2: [0], 3: [2]}


def test_the_last_object_of_a_cell_is_not_borrowed():
    assert found(objects((1.02, 0.5), (1.5, 1.5))) == {2: [0], 3: [1]}


def test_an_object_is_borrowed_once():
    table = objects((1.01, 1.01), (1.5, 1.5))  # near three empty cells
    assert sorted(found(table).values()) == [[0], [1]]


def test_objects_outside_the_space_lie_at_its_edge():
    assert found(objects((-3, 0.5), (-1, 0.5), (0.2, 5), (0.5, 1.5))) == {0: [0, 1], 1: [2, 3]}


@pytest.mark.parametrize("far", [0.1, 0.3])
def test_how_far_is_a_setting(far):
    table = objects((1.2, 0.5), (1.5, 0.5))
    cells = candidates_by_cell(table, SelectEval(rows=2, columns=2, borrow=far), SPACE)
    assert (0 in cells) == (far > 0.2)


def test_every_place_has_a_name_that_tells_it():
    names = labels_of(26, 10)
    assert len(set(names)) == 260
    assert [label_at(*cell_of_label(name)) for name in names] == names
    assert [cell_of_label(name) for name in labels_of(2, 2)] == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert all(LABEL.fullmatch(name) for name in names)
