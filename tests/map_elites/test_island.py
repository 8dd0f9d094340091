from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from egad._util.workers import workers
from egad.map_elites.archive import Archive, elites_of, merge
from egad.map_elites.island import Island, Measured, Solid, evolve, measure, reevaluate
from egad.map_elites.parameters import EvolutionParameters
from egad.map_elites.variation import LEAST, breed, parent_odds
from egad.pipeline.config import Difficulty, Evolution, Settings, Shape, Similarity
from egad.pipeline.config.stage_settings import select
from egad.tables import parquet
from egad.tables.evolution import EPOCH, HISTORY

SETTINGS = select(
    Settings(
        evolution=Evolution(steps_per_epoch=2, population=12),
        shape=Shape(resolution=16),
        difficulty=Difficulty(grasps=8),
        similarity=Similarity(vertices=300, ranges=16, base_count=8),
    ),
    EvolutionParameters,
)


def is_measured(result):
    return isinstance(result, Measured)


def evolved(worker_count, **names):
    archive = Archive(SETTINGS.space, SETTINGS.similarity)
    with workers(worker_count) as mapper:
        history, counts = evolve(archive, SETTINGS, **names, mapper=mapper)
    return archive, counts, history


@pytest.fixture(scope="module")
def island():
    return evolved(1, epoch=0, island=0)


def test_what_watches_is_told_of_every_step_and_changes_nothing(island):
    told = []
    archive = Archive(SETTINGS.space, SETTINGS.similarity)

    def watch(now, steps):
        told.append((len(now.elites), len(steps)))

    history, _ = evolve(archive, SETTINGS, 0, 0, watch=watch)
    assert told == list(zip(history["elites"], [1, 2], strict=True))
    pd.testing.assert_frame_equal(history, island[2])


def test_every_offspring_is_accounted_for(island):
    _, counts, _ = island
    assert counts.total() == 2 * 12
    assert counts["evaluated"] > 5
    assert counts["empty"] > 0


def test_two_workers_give_the_same_bytes_as_one(island, tmp_path):
    one, _, first = island
    two, _, second = evolved(2, epoch=0, island=0)
    pd.testing.assert_frame_equal(first, second)
    parquet.write(one.to_frame(), EPOCH, tmp_path / "one")
    parquet.write(two.to_frame(), EPOCH, tmp_path / "two")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


@pytest.mark.parametrize("count", [1, 2, 8])
def test_islands_that_evolve_apart_and_merge_can_be_repeated(count):
    def run():
        frames = [evolved_again([], 0, number) for number in range(count)]
        merged = merge(frames, SETTINGS.space, SETTINGS.similarity)
        frames = [evolved_again(elites_of(merged), 1, number) for number in range(count)]
        return merge(frames, SETTINGS.space, SETTINGS.similarity)

    def evolved_again(elites, epoch, number):
        archive = Archive(SETTINGS.space, SETTINGS.similarity)
        archive.add(elites)
        evolve(archive, with_search(population=4, steps_per_epoch=1), epoch, number)
        return archive.to_frame()

    pd.testing.assert_frame_equal(run(), run())


def test_another_island_and_another_epoch_find_other_objects(island):
    ids = {each.id for each in island[0].elites}
    assert {each.id for each in evolved(1, epoch=0, island=1)[0].elites} != ids
    assert {each.id for each in evolved(1, epoch=1, island=0)[0].elites} != ids


def test_offspring_of_an_archive_have_parents_from_it(island):
    elites = island[0].elites
    ids = {each.id for each in elites}
    offspring = breed(elites, SETTINGS, 0, 0, 5)
    assert len(offspring) == 12
    assert {parent for each in offspring for parent in each.parents} <= ids
    assert {len(each.parents) for each in offspring} == {1, 2}


def test_without_elites_offspring_are_random():
    assert [each.parents for each in breed([], SETTINGS, 0, 0, 0)] == [()] * 12


def test_a_solid_has_the_same_measures_whoever_bred_it(island):
    for each in island[0].elites[:3]:
        again = measure(Solid(each.id, each.voxels), SETTINGS)
        assert (again.complexity, again.difficulty) == (each.complexity, each.difficulty)


def test_the_history_tells_every_step(island):
    archive, counts, history = island
    assert history.columns.tolist() == HISTORY.names
    assert history["step"].tolist() == [0, 1]
    assert history["offspring"].sum() == counts.total()
    assert history["evaluated"].sum() == counts["evaluated"]
    last = history.iloc[-1]
    assert last["elites"] == len(archive) == sum(last["cells"])
    assert last["coverage"] == archive.coverage
    assert last["qd_score"] == pytest.approx(archive.to_frame()["diversity"].sum())
    assert np.isnan(history["qd_score"].iloc[0])


def with_search(**search):
    changed = SETTINGS.evolution.model_copy(update=search)
    return SETTINGS.model_copy(update={"evolution": changed})


def test_sparse_parents_are_those_with_empty_places_around_them(island):
    elites = island[0].elites
    corner = replace(elites[0], id="corner", complexity=5.0, difficulty=0.0005)
    places = np.array([32, 32, 32, 32, 15])  # of 9 cells, the middle one full; of 4
    middle = replace(elites[0], complexity=3.0, difficulty=0.002)
    crowded = [replace(middle, id=str(number)) for number in range(4)]
    odds = parent_odds([*crowded, corner], SETTINGS.space)
    weights = places + LEAST
    assert odds == pytest.approx(weights / weights.sum())


def test_siblings_share_their_parents(island):
    litter = breed(island[0].elites, with_search(siblings=3), 0, 0, 7)
    for start in range(0, 12, 3):
        assert len({each.parents for each in litter[start : start + 3]}) == 1
    assert len({each.parents for each in litter}) > 1


def test_restarts_have_no_parents(island):
    parents = [each.parents for each in breed(island[0].elites, with_search(restart=1.0), 0, 0, 7)]
    assert parents == [()] * 12


def test_newcomers_to_full_cells_are_graded_again(monkeypatch):
    """Here all objects share one cell, which the first ones fill."""
    one_cell = SETTINGS.space.model_copy(update={"cells": 1, "elites_per_cell": 1})
    settings = with_search(reevaluation_grasps=20).model_copy(update={"space": one_cell})
    archive = Archive(one_cell, settings.similarity)
    told = []
    tell = Island.tell
    monkeypatch.setattr(Island, "tell", lambda *all: (told.append(all[1:]), tell(*all)))
    run = Island(archive, settings, 0, 0)
    run.advance()
    run.advance()
    for (candidates, results), again in zip(told, (False, True), strict=True):
        found = [(c.solid, r) for c, r in zip(candidates, results, strict=True) if is_measured(r)]
        assert len(found) > 3
        for solid, result in found:
            grade = reevaluate(solid, settings) if again else measure(solid, settings).difficulty
            assert result.difficulty == grade


def test_a_newcomer_is_graded_again_by_other_grasps(island):
    """As many as before: the same ones would be as lucky again."""
    settings = with_search(reevaluation_grasps=SETTINGS.difficulty.grasps)
    for each in island[0].elites[:3]:
        solid = Solid(each.id, each.voxels)
        assert reevaluate(solid, settings) != measure(solid, settings).difficulty
