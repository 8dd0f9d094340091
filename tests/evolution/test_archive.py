import itertools
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from egad.evolution import Archive, Elite, elites_of, merge, ribs_frame
from egad.measures import MeasureSpace
from egad.measures.grid import complexity_cells, difficulty_cells
from egad.measures.reeb import Similarity
from egad.measures.reeb import graph as reeb
from egad.measures.reeb.similarity import similarity
from egad.tables import parquet
from egad.tables.evolution import EPOCH, GENOME

SIMILARITY = Similarity(vertices=200, ranges=16, base_count=10)
SPACE = MeasureSpace(cells=2, elites_per_cell=2, neighbors=3)
GENOME = {name: [] for name in GENOME.names}


def elite(mesh, number, cell=(0, 0)):
    """A mesh in a given cell of the 2 x 2 space."""
    return Elite(
        id=f"{number:03d}",
        genome=GENOME,
        voxels=bytes([number]),
        complexity=[2.0, 4.0][cell[0]],
        graspability=[0.003, 0.001][cell[1]],
        graph=reeb.extract(mesh, SIMILARITY),
        parents=(),
        epoch=0,
    )


@pytest.fixture(scope="module")
def elites(spiky_box):
    cells = list(itertools.product((0, 1), (0, 1)))
    return [elite(spiky_box(number), number, cells[number % 3]) for number in range(18)]


def filled(*batches, space=SPACE, threads=1):
    archive = Archive(space, SIMILARITY, threads)
    for batch in batches:
        archive.add(batch)
    return archive


def slow_archive(batches, space):
    """The paper's rule, all distances computed again after every removal."""

    def diversity(one):
        distances = sorted(1 - similarity(one.graph, o.graph, 0.5) for o in kept if o is not one)
        return np.mean(distances[: space.neighbors])

    kept = []
    for batch in batches:
        kept += [each for each in batch if each.id not in {k.id for k in kept}]
        while True:
            cells = [(k.complexity, k.graspability) for k in kept]
            crowded = [
                k
                for k, c in zip(kept, cells, strict=True)
                if cells.count(c) > space.elites_per_cell
            ]
            if not crowded:
                break
            kept.remove(min(crowded, key=lambda k: (diversity(k), k.id)))
    return {k.id for k in kept}


@pytest.mark.parametrize("neighbors", [1, 3, 8, 30])
def test_equals_the_rule_done_slowly(elites, neighbors):
    space = SPACE.model_copy(update={"neighbors": neighbors})
    batches = [elites[:7], elites[5:12], elites[10:]]
    archive = filled(*batches, space=space)
    assert {each.id for each in archive.elites} == slow_archive(batches, space)
    assert len(archive) == 6


def test_uncertain_elites_go_before_less_diverse_ones(elites):
    """The twin: the rule of the paper among the certain ones, if these fill the cell."""
    space = SPACE.model_copy(update={"confidence": 0.9})
    some = [replace(each, graspability=0.003, complexity=2.0) for each in elites[:8]]
    doubtful = [replace(each, cell_confidence=0.5) for each in some[:3]]
    sure = [replace(each, cell_confidence=0.95) for each in some[3:]]
    archive = filled([*doubtful, *sure], space=space)
    assert {each.id for each in archive.elites} == slow_archive([sure], space)
    archive = filled([*doubtful, sure[0]], space=space)
    assert sure[0].id in archive
    assert len(archive) == 2


def test_a_certain_candidate_takes_the_slot_of_an_uncertain_elite(elites):
    """Even if it is less diverse; an uncertain one never takes that of a certain elite."""
    space = SPACE.model_copy(update={"confidence": 0.9, "elites_per_cell": 1})
    here = [replace(each, graspability=0.003, complexity=2.0) for each in elites[:5]]
    for old, new in itertools.permutations(here, 2):
        for before, after in ((0.5, 0.95), (0.95, 0.5)):
            archive = filled([replace(old, cell_confidence=before)], space=space)
            archive.add([new], lambda some, c=after: [replace(e, cell_confidence=c) for e in some])
            assert (new if after > before else old).id in archive
            assert len(archive) == 1


def test_only_what_its_cell_would_keep_is_refined(elites):
    asked = []

    def refine(chosen):
        asked.append([each.id for each in chosen])
        return chosen

    cell = [replace(each, graspability=0.003, complexity=2.0) for each in elites]
    archive = Archive(SPACE, SIMILARITY)
    archive.add(cell[:9], refine)
    assert len(asked[0]) == 2
    assert {each.id for each in archive.elites} == set(asked[0])
    archive.add(cell[9:], refine)
    assert len(asked[1]) < 9
    assert {each.id for each in archive.elites} <= set(asked[0] + asked[1])


def test_refined_candidates_compete_where_they_turn_out_to_be(elites):
    """One goes to another cell, one has no grasp; the elite that they would replace stays."""
    here = [replace(each, graspability=0.003, complexity=2.0) for each in elites[:2]]
    archive = filled(here)

    def refine(chosen):
        found = {each.id: None for each in chosen}
        for each in chosen[::2]:
            found[each.id] = replace(each, graspability=0.001, graspability_std=0.1)
        return list(found.values())

    new = [replace(each, graspability=0.003, complexity=2.0) for each in elites[2:12]]
    archive.add(new, refine)
    moved = [each for each in archive.elites if each.id not in {e.id for e in here}]
    assert {each.id for each in here} <= {each.id for each in archive.elites}
    assert {archive.cell(each) for each in moved} == {(0, 1)}
    assert {each.graspability_std for each in moved} == {0.1}


def test_of_equally_diverse_ones_the_first_name_goes(elites):
    twins = [replace(each, id=f"twin {each.id}") for each in elites]
    space = SPACE.model_copy(update={"elites_per_cell": 4})
    batches = [elites[:9] + twins[:9], elites[9:] + twins[9:]]
    found = {each.id for each in filled(*batches, space=space).elites}
    assert found == slow_archive(batches, space)


def test_any_number_of_threads_keeps_the_same(elites):
    batches = elites[:7], elites[5:12], elites[10:]
    tables = [filled(*batches, threads=threads).to_frame() for threads in (1, 3)]
    pd.testing.assert_frame_equal(*tables)


def test_no_cell_holds_too_many_and_coverage_counts_places(elites):
    archive = filled(elites)
    frame = archive.to_frame()
    assert frame.groupby(["complexity_cell", "difficulty_cell"]).size().max() == 2
    assert archive.coverage == pytest.approx(6 / 8)


def test_table_round_trip_gives_the_same_table(elites, tmp_path):
    parquet.write(filled(elites).to_frame(), EPOCH, tmp_path / "one")
    again = filled(elites_of(parquet.read(tmp_path / "one", EPOCH)))
    parquet.write(again.to_frame(), EPOCH, tmp_path / "two")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_slots_count_within_a_cell_from_the_most_diverse(elites):
    for _, cell in filled(elites).to_frame().groupby(["difficulty_cell", "complexity_cell"]):
        assert list(cell["slot"]) == list(range(len(cell)))
        assert (np.diff(cell["diversity"]) <= 0).all()


def test_an_empty_archive_has_an_empty_table():
    frame = Archive(SPACE, SIMILARITY).to_frame()
    assert list(frame.columns) == EPOCH.names
    assert len(frame) == 0


def test_merging_keeps_the_survivors_of_all_islands_by_the_rule(elites):
    frames = [filled(half).to_frame() for half in (elites[:9], elites[9:])]
    survivors = [each for frame in frames for each in elites_of(frame)]
    merged = merge(frames, SPACE, SIMILARITY)
    assert set(merged["id"]) == slow_archive([survivors], SPACE)


def test_indices_are_those_of_a_grid_over_the_measures():
    """The twin: pyribs' grid over two ranges, by searching the edges."""
    space = MeasureSpace(cells=5)
    rng = np.random.default_rng(0)
    complexity, graspability = rng.uniform(1, 5, 50), rng.uniform(0.0005, 0.004, 50)
    archive = pd.DataFrame(
        {
            "id": [str(number) for number in range(50)],
            "complexity": complexity,
            "graspability": graspability,
            "diversity": rng.random(50),
            "complexity_cell": complexity_cells(complexity, space),
            "difficulty_cell": difficulty_cells(graspability, space),
        }
    )
    frame = ribs_frame(archive, space)
    first = np.searchsorted(np.linspace(1, 5, 6), complexity) - 1
    second = np.searchsorted(np.linspace(0.0005, 0.004, 6), graspability) - 1
    assert frame["index"].tolist() == (5 * first + second).tolist()
    assert frame["objective"].tolist() == archive["diversity"].tolist()
