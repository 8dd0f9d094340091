"""Evolution from Python, in one call and step by step, against the island of the pipeline."""

import numpy as np
import pandas as pd
import pytest

import egad
from egad.errors import RejectedError, UserError
from egad.map_elites import island
from egad.map_elites.archive import Archive
from egad.map_elites.parameters import EvolutionParameters
from egad.pipeline.config import Settings
from egad.pipeline.config.stage_settings import select

RANGES = ((0.0, 3e-4), (1.0, 4.0))


def bulk_and_length(mesh):
    """Two measures that are quick."""
    return mesh.volume, mesh.extents.max() / mesh.extents.min()


def fussy(mesh):
    if mesh.volume > 1e-4:
        raise RejectedError("too bulky")
    return bulk_and_length(mesh)


@pytest.fixture(scope="module")
def archive():
    return egad.evolve(48, seed=5, measures=bulk_and_length, ranges=RANGES, population=16)


def test_evolution_is_that_of_an_island_of_the_pipeline():
    evolution = {"steps_per_epoch": 2, "population": 8}
    settings = select(
        Settings.model_validate({"seed": 3, "evolution": evolution}), EvolutionParameters
    )
    expected = Archive(settings.space, settings.similarity)
    island.evolve(expected, settings, 0, 0)
    found = egad.evolve(16, seed=3, population=8)
    pd.testing.assert_frame_equal(found.to_frame(), expected.to_frame())


def test_step_by_step_gives_the_same_archive(archive):
    evolver = egad.Evolver(seed=5, population=16, ranges=RANGES)
    for _ in range(3):
        evolver.tell([bulk_and_length(each.mesh) for each in evolver.ask()])
    pd.testing.assert_frame_equal(evolver.archive.to_frame(), archive.to_frame())


def test_two_processes_give_the_same_archive(archive):
    other = egad.evolve(48, seed=5, measures=bulk_and_length, ranges=RANGES, population=16, jobs=2)
    pd.testing.assert_frame_equal(other.to_frame(), archive.to_frame())


def test_measures_decide_the_cells(archive):
    frame = archive.to_frame()
    assert len(frame) > 5
    for each, row in zip(egad.load(archive), frame.itertuples(), strict=True):
        assert each.id == row.id
        volume = np.floor(25 * row.complexity / 3e-4)
        assert row.complexity_cell == np.clip(volume, 0, 24)
        assert each.voxels.sum() > 0
        assert each.mesh.volume == pytest.approx(row.complexity, rel=1e-6)


def test_a_rejected_or_missing_measure_leaves_an_object_out(archive):
    some = egad.evolve(48, seed=5, measures=fussy, ranges=RANGES, population=16)
    assert len(some) > 0
    assert some.to_frame()["complexity"].max() <= 1e-4 < archive.to_frame()["complexity"].max()
    evolver = egad.Evolver(population=8)
    evolver.tell(np.full((len(evolver.ask()), 2), np.nan))
    assert len(evolver.archive) == 0


def test_steps_out_of_order_and_wrong_numbers_are_refused():
    evolver = egad.Evolver(population=8)
    with pytest.raises(UserError, match="ask for candidates"):
        evolver.tell([])
    count = len(evolver.ask())
    with pytest.raises(UserError, match="tell the measures"):
        evolver.ask()
    for shape in ((count + 1, 2), (2, count), (2 * count,)):
        with pytest.raises(UserError, match=rf"of shape \({count}, 2\)"):
            evolver.tell(np.ones(shape))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"evaluations": 0}, "evaluations is 0; .*at least 1"),
        ({"evaluations": 1.5}, "evaluations is 1.5"),
        ({"population": 0}, "population is 0; allowed: a whole number, at least 1"),
        ({"seed": "x"}, "seed is 'x'; allowed: a whole number"),
        ({"jobs": 0}, "jobs is 0"),
        ({"measures": lambda mesh: (mesh.volume, 1.0), "jobs": 2}, "that can be imported"),
        ({"ranges": ((1, 0), (0, 1))}, r"ranges is \(\(1, 0\).*each from low to high"),
        ({"ranges": ((0, 1), (0, np.inf))}, "two ranges of finite numbers"),
        ({"ranges": (0, 1)}, "two ranges"),
        ({"ranges": (("a", "b"), (0, 1))}, "two ranges"),
        ({"ranges": None}, "two ranges"),
    ],
)
def test_wrong_arguments_of_evolution_are_named(wrong, message):
    with pytest.raises(UserError, match=message):
        egad.evolve(**{"evaluations": 8} | wrong)


@pytest.mark.parametrize(
    ("name", "value"), [("cells", 27), ("elites_per_cell", 0), ("population", -1)]
)
def test_wrong_arguments_of_an_evolver_are_named(name, value):
    with pytest.raises(UserError, match=f"^{name} is {value}; allowed: a whole number"):
        egad.Evolver(**{name: value})
