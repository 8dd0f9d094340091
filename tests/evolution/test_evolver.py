"""Evolution from Python, in one call and step by step, against the island of the pipeline."""

import math
import threading

import numpy as np
import pandas as pd
import pytest

import egad
from egad.errors import RejectedError, UserError
from egad.evolution import Archive, EvolutionParameters, island
from egad_workflow.settings import Settings, select

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
    evolution = {"evaluations": 16, "population": 8}
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
    def measures(mesh):  # which cannot be imported
        return bulk_and_length(mesh)

    other = egad.evolve(48, seed=5, measures=measures, ranges=RANGES, population=16, jobs=2)
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


@pytest.mark.parametrize("evaluations", [40, 2000])
def test_a_measure_that_is_always_nan_is_told(evaluations):
    """Soon, and not when all evaluations are done."""
    asked = []

    def measures(mesh):
        asked.append(mesh)
        return math.nan, 0.5

    with pytest.raises(UserError, match="the measures are not two finite numbers"):
        egad.evolve(evaluations, measures=measures, population=20)
    assert len(asked) < 150


def test_steps_out_of_order_and_wrong_numbers_are_refused():
    evolver = egad.Evolver(population=8)
    with pytest.raises(UserError, match="ask for candidates"):
        evolver.tell([])
    count = len(evolver.ask())
    with pytest.raises(UserError, match="tell the measures"):
        evolver.ask()
    ragged = [*[(1.0, 2.0)] * (count - 1), (1.0, 2.0, 3.0)]
    for wrong in (*map(np.ones, ((count + 1, 2), (2, count), (2 * count,))), "x", None, ragged):
        with pytest.raises(UserError, match=rf"of shape \({count}, 2\)"):
            evolver.tell(wrong)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"evaluations": 0}, "evaluations is 0; .*at least 1"),
        ({"population": "10"}, "population is '10'; allowed: a whole number, at least 1"),
        ({"cells": 27}, "cells is 27; allowed: a whole number, 1 to 26"),
        ({"measures": "volume"}, "measures is 'volume'; allowed: a function"),
        ({"measures": threading.Lock().acquire, "jobs": 2}, "cannot be sent to another process"),
        ({"ranges": ((1, 0), (0, 1))}, r"ranges is \(\(1, 0\).*each from low to high"),
        ({"ranges": ((0, 1), (0, np.inf))}, "two ranges of finite numbers"),
    ],
)
def test_wrong_arguments_of_evolution_are_named(wrong, message):
    with pytest.raises(UserError, match=message):
        egad.evolve(**{"evaluations": 8} | wrong)


@pytest.mark.parametrize("returned", [(1, 2, 3), 1.0, None, "ab", ("a", "b"), ((1, 2), (3, 4))])
def test_measures_that_are_not_two_numbers_are_told(returned):
    with pytest.raises(UserError, match="measures of a mesh must be two numbers, got"):
        egad.evolve(8, measures=lambda _: returned, population=8)
