from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from egad._util.workers import workers
from egad.errors import UserError
from egad.evolution import (
    Archive,
    Evolution,
    EvolutionParameters,
    Shape,
    ancestors,
    breed,
    elites_of,
    evolve,
    merge,
)
from egad.evolution.evaluation import GenomeVoxels, measure, refine
from egad.evolution.island import Island
from egad.evolution.variation import MIN_WEIGHT, parent_odds
from egad.measures import Graspability
from egad.measures.reeb import Similarity
from egad.tables import parquet
from egad.tables.evolution import EPOCH, HISTORY
from egad_workflow.settings import Settings, select

SETTINGS = select(
    Settings(
        evolution=Evolution(evaluations=24, population=12, max_candidates=256),
        shape=Shape(resolution=16),
        graspability=Graspability(candidates=64),
        similarity=Similarity(vertices=300, ranges=16, base_count=8),
    ),
    EvolutionParameters,
)


def test_evaluations_are_rounded_up_to_whole_steps():
    steps = [Evolution(evaluations=count, population=10).steps for count in (1, 10, 11)]
    assert steps == [1, 1, 2]
    assert Evolution().evaluations == Evolution().steps * Evolution().population


def evolved(worker_count, **names):
    archive = Archive(SETTINGS.space, SETTINGS.similarity)
    with workers(worker_count) as mapper:
        done = evolve(archive, SETTINGS, **names, mapper=mapper)
    return archive, done


@pytest.fixture(scope="module")
def island():
    return evolved(1, epoch=0, island=0)


def test_a_search_without_any_measure_stops_with_the_reason(island, monkeypatch):
    """One whose archive has objects goes on, though the new ones have no measures."""
    monkeypatch.setattr("egad.evolution.island.UNMEASURED", 3)
    nothing = Archive(SETTINGS.space, SETTINGS.similarity)
    something = island[0]
    for archive in (nothing, something):
        search = Island(archive, SETTINGS, 1, 0, evaluate=lambda _: "mine is not finite (nan)")
        if archive is something:
            assert search.advance().accepted == []
            assert search.outcomes["mine is not finite"] >= 3
        else:
            with pytest.raises(UserError, match="none of the first"):
                search.advance()


def test_every_offspring_is_accounted_for(island):
    counts = island[1].outcomes
    assert counts.total() == 2 * 12
    assert counts["evaluated"] > 5
    assert counts["empty"] > 0


def test_two_workers_give_the_same_bytes_as_one(island, tmp_path):
    one, first = island
    two, second = evolved(2, epoch=0, island=0)
    pd.testing.assert_frame_equal(first.history, second.history)
    pd.testing.assert_frame_equal(first.lineage, second.lineage)
    parquet.write(one.to_frame(), EPOCH, tmp_path / "one")
    parquet.write(two.to_frame(), EPOCH, tmp_path / "two")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


@pytest.mark.parametrize("count", [1, 3])
def test_islands_that_evolve_apart_and_merge_can_be_repeated(count):
    def run():
        frames = [evolved_again([], 0, number) for number in range(count)]
        merged = merge(frames, SETTINGS.space, SETTINGS.similarity)
        frames = [evolved_again(elites_of(merged), 1, number) for number in range(count)]
        return merge(frames, SETTINGS.space, SETTINGS.similarity)

    def evolved_again(elites, epoch, number):
        archive = Archive(SETTINGS.space, SETTINGS.similarity)
        archive.add(elites)
        evolve(archive, with_search(population=4, evaluations=4), epoch, number)
        return archive.to_frame()

    pd.testing.assert_frame_equal(run(), run())


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
        again = measure(GenomeVoxels(each.id, each.voxels), SETTINGS)
        assert again.complexity == each.complexity
        assert refine(replace(each, graspability=again.graspability), SETTINGS) == each


def test_the_paper_measures_once():
    settings = with_search(estimator="paper", grasps=20)
    archive = Archive(settings.space, settings.similarity)
    done = evolve(archive, settings, 0, 0)
    assert done.history["refined"].tolist() == [0, 0]
    for each in archive.elites[:3]:
        again = measure(GenomeVoxels(each.id, each.voxels), settings)
        assert again.graspability == each.graspability
        assert np.isnan([each.graspability_std, each.cell_confidence]).all()


def test_what_the_archive_would_keep_is_refined_by_other_grasps(island):
    archive, done = island
    evaluated, refined = (done.history[name] for name in ("evaluated", "refined"))
    assert (refined > 0).all()
    assert (refined <= evaluated).all()
    assert len(archive) <= refined.sum()
    for each in archive.elites:
        assert each.graspability_std > 0
        assert 0 < each.cell_confidence <= 1
        assert (
            measure(GenomeVoxels(each.id, each.voxels), SETTINGS).graspability != each.graspability
        )


def test_the_lineage_holds_all_that_the_archive_took_in(island):
    archive, done = island
    ids = done.lineage["id"]
    assert {each.id for each in archive.elites} <= set(ids)
    parents = {name for row in done.lineage["parents"] for name in row}
    assert parents <= set(ids)
    table = ancestors([each.id for each in archive.elites], done.lineage)
    assert len(table) >= len(archive)


def test_the_history_tells_every_step(island):
    archive, (history, _, counts) = island
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
    corner = replace(elites[0], id="corner", complexity=5.0, graspability=0.0005)
    places = np.array([32, 32, 32, 32, 15])  # of 9 cells, the middle one full; of 4
    middle = replace(elites[0], complexity=3.0, graspability=0.002)
    crowded = [replace(middle, id=str(number)) for number in range(4)]
    odds = parent_odds([*crowded, corner], SETTINGS.space)
    weights = places + MIN_WEIGHT
    assert odds == pytest.approx(weights / weights.sum())


def test_siblings_share_their_parents(island):
    litter = breed(island[0].elites, with_search(siblings=3), 0, 0, 7)
    for start in range(0, 12, 3):
        assert len({each.parents for each in litter[start : start + 3]}) == 1
    assert len({each.parents for each in litter}) > 1


def test_restarts_have_no_parents(island):
    parents = [each.parents for each in breed(island[0].elites, with_search(restart=1.0), 0, 0, 7)]
    assert parents == [()] * 12
