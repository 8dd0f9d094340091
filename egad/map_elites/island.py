"""One epoch of an island: vary elites, evaluate the offspring, update the archive."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from egad._util.progress import progress
from egad._util.workers import Mapper
from egad.cppn import constraints, voxels
from egad.cppn import query as cppn
from egad.cppn.constraints import UNBOUND, Rules
from egad.cppn.genome import Row
from egad.cppn.surface import packed_surface
from egad.errors import RejectedError
from egad.map_elites.archive import Archive, Elite
from egad.map_elites.parameters import EvolutionParameters
from egad.map_elites.variation import Offspring, breed
from egad.measures.grid import coverage_of, filled_part
from egad.measures.measure import coordinates
from egad.random import generator
from egad.reeb import graph as reeb
from egad.tables.evolution import HISTORY

EVALUATED, EMPTY, KNOWN = "evaluated", "empty", "known already"
SCORED = 10  # the QD-score of every so many steps is computed
LINE = "coverage {coverage:.3f}, {elites} elites"
Watch = Callable[[Archive, Sequence[Mapping[str, Any]]], None]


@dataclass(frozen=True)
class Solid:
    """The voxels that a genome stands for."""

    id: str
    packed: bytes


@dataclass(frozen=True)
class Measured:
    """The measures of a solid."""

    complexity: float
    difficulty: float
    graph: reeb.ReebGraph


def express(row: Row, settings: EvolutionParameters, rules: constraints.Rules) -> Solid | str:
    """The solid of a genome, or the reason why it is none that is allowed."""
    shape = settings.shape
    output = cppn.query(row, shape.resolution, rules.symmetry)
    try:
        solid = constraints.solid(output, shape.threshold, rules)
    except RejectedError as error:
        return str(error)
    return Solid(voxels.identity(solid), voxels.pack(solid))


def measure(solid: Solid, settings: EvolutionParameters) -> Measured | str:
    """The measures of a solid, or the reason why it has none.

    The grasps are drawn from a generator named after the solid, so equal solids have equal
    measures wherever and whenever they are found, but for newcomers that are graded again.
    """
    mesh = packed_surface(solid.packed, settings.shape)
    rng = generator(settings.seed, "difficulty", solid.id)
    try:
        place = coordinates(mesh, settings, settings.difficulty.grasps, rng)
        graph = reeb.extract(mesh, settings.similarity)
        return Measured(place.complexity, place.difficulty, graph)
    except RejectedError as error:
        return str(error)


def regrade(solid: Solid, settings: EvolutionParameters) -> float | str:
    """The difficulty of a solid by other grasps, or the reason why it has none."""
    mesh = packed_surface(solid.packed, settings.shape)
    rng = generator(settings.seed, "newcomer", solid.id)
    try:
        return coordinates(mesh, settings, settings.evolution.regrade, rng).difficulty
    except RejectedError as error:
        return str(error)


class Step(NamedTuple):
    """Names one step."""

    epoch: int
    island: int
    step: int


def evolve(
    archive: Archive,
    settings: EvolutionParameters,
    epoch: int,
    island: int,
    rules: Rules = UNBOUND,
    mapper: Mapper = map,
    watch: Watch | None = None,
) -> tuple[pd.DataFrame, Counter[str]]:
    """Run the steps of one epoch of one island on its archive.

    Args:
        archive: Changed in place.
        settings: Everything about breeding and measuring.
        epoch: Number of the epoch.
        island: Number of the island.
        rules: What every shape must obey.
        mapper: An order-keeping `map`; where it runs does not change the result.
        watch: Is told of the archive and the steps so far after each step, and may not change them.

    Returns:
        The steps, with the columns of `tables.evolution.HISTORY`; and how many offspring were
        evaluated, empty, known already, or rejected for which reason.
    """
    rows: list[dict[str, Any]] = []
    total = Counter[str]()
    steps = settings.evolution.steps_per_epoch
    size = settings.evolution.population
    words = partial(_standing, rows)
    for number in progress(range(steps), "evaluations", steps, scale=size, state=words):
        step = Step(epoch, island, number)
        offspring = breed(archive.elites, settings, *step)
        elites, outcomes = _evaluated(offspring, archive, settings, epoch, rules, mapper)
        archive.add(elites)
        total += outcomes
        scored = number % SCORED == SCORED - 1 or number == steps - 1
        rows.append({**step._asdict(), **snapshot(archive, outcomes, scored)})
        if watch:
            watch(archive, rows)
    return pd.DataFrame(rows, columns=HISTORY.names), total


def snapshot(archive: Archive, outcomes: Counter[str], scored: bool) -> dict[str, Any]:
    """What a step did: columns of `tables.evolution.HISTORY` except for the names of the step.

    Args:
        archive: After the step.
        outcomes: How many offspring were evaluated, empty, known already, or rejected for which
            reason.
        scored: Whether to compute the QD-score, which asks for all diversities.
    """
    counts = archive.counts()
    return {
        "offspring": outcomes.total(),
        "evaluated": outcomes[EVALUATED],
        "empty": outcomes[EMPTY],
        "known": outcomes[KNOWN],
        "elites": len(archive),
        "coverage": coverage_of(counts, archive.space),
        "filled_cells": filled_part(counts),
        "qd_score": archive.qd_score if scored else math.nan,
        "cells": counts.astype(np.uint8).tobytes(),
    }


def _standing(rows: list[dict[str, Any]]) -> str:
    """How the search stands; its QD-score is not taken at every step."""
    scored = (row["qd_score"] for row in reversed(rows) if not math.isnan(row["qd_score"]))
    score = next((f", QD-score {score:.1f}" for score in scored), "")
    return LINE.format(**rows[-1]) + score if rows else ""


def _evaluated(
    offspring: list[Offspring],
    archive: Archive,
    settings: EvolutionParameters,
    epoch: int,
    rules: Rules,
    mapper: Mapper,
) -> tuple[list[Elite], Counter[str]]:
    """The offspring that are new and can be measured, and what became of all."""
    fresh, outcomes = _fresh(offspring, archive, settings, rules, mapper)
    solids = [solid for _, solid in fresh]
    results = list(mapper(partial(measure, settings=settings), solids))
    if settings.evolution.regrade:
        results = _regraded(solids, results, archive, settings, mapper)
    elites = []
    for (each, solid), result in zip(fresh, results, strict=True):
        if isinstance(result, Measured):
            outcomes[EVALUATED] += 1
            elites.append(_elite(each, solid, result, epoch))
        else:
            outcomes[_kind(result)] += 1
    return elites, outcomes


def _fresh(
    offspring: list[Offspring],
    archive: Archive,
    settings: EvolutionParameters,
    rules: Rules,
    mapper: Mapper,
) -> tuple[list[tuple[Offspring, Solid]], Counter[str]]:
    """The offspring whose voxels are not known yet, and how many others there are."""
    outcomes: Counter[str] = Counter()
    work = partial(express, settings=settings, rules=rules)
    solids = mapper(work, [each.genome for each in offspring])
    fresh: dict[str, tuple[Offspring, Solid]] = {}
    for each, solid in zip(offspring, solids, strict=True):
        if isinstance(solid, str):
            outcomes[_kind(solid)] += 1
        elif solid.id in archive or solid.id in fresh:
            outcomes[KNOWN] += 1
        else:
            fresh[solid.id] = each, solid
    return list(fresh.values()), outcomes


def _regraded(
    solids: list[Solid],
    results: list[Measured | str],
    archive: Archive,
    settings: EvolutionParameters,
    mapper: Mapper,
) -> list[Measured | str]:
    """The results, those graded again that would have to replace an elite (ours)."""
    places = [
        index
        for index, result in enumerate(results)
        if isinstance(result, Measured) and archive.is_full(result.complexity, result.difficulty)
    ]
    grades = mapper(partial(regrade, settings=settings), [solids[index] for index in places])
    for index, grade in zip(places, grades, strict=True):
        first = results[index]
        if isinstance(first, Measured) and isinstance(grade, float):
            results[index] = replace(first, difficulty=grade)
        else:
            results[index] = grade
    return results


def _kind(reason: str) -> str:
    """A reason without its numbers."""
    return reason.partition(" (")[0]


def _elite(offspring: Offspring, solid: Solid, measured: Measured, epoch: int) -> Elite:
    return Elite(
        id=solid.id,
        genome=offspring.genome,
        voxels=solid.packed,
        complexity=measured.complexity,
        difficulty=measured.difficulty,
        graph=measured.graph,
        parents=offspring.parents,
        epoch=epoch,
    )
