"""One epoch of an island: vary elites, evaluate the offspring, update the archive."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray

from egad._util.progress import progress
from egad._util.workers import Mapper
from egad.cppn import UNBOUND, Row, Rules, Shape, constraints, packed_surface, voxels
from egad.cppn import query as cppn
from egad.errors import RejectedError
from egad.map_elites.archive import Archive, Elite
from egad.map_elites.parameters import EvolutionParameters
from egad.map_elites.variation import Offspring, breed
from egad.measures import coverage_of, filled_part, measure_mesh
from egad.random import generator
from egad.reeb import graph as reeb
from egad.tables.evolution import HISTORY

EVALUATED, EMPTY, KNOWN = "evaluated", "empty", "known already"
SCORED = 10  # the QD-score is computed once in as many steps
LINE = "coverage {coverage:.3f}, {elites} elites"
Watch = Callable[[Archive, Sequence[Mapping[str, Any]]], None]


@dataclass(frozen=True)
class Solid:
    """The voxels that a genome stands for."""

    id: str
    packed: bytes


@dataclass(frozen=True)
class Candidate:
    """A new shape that is to be measured."""

    offspring: Offspring
    solid: Solid
    shape: Shape

    @property
    def id(self) -> str:
        """Hash of its voxels."""
        return self.solid.id

    @property
    def voxels(self) -> NDArray[np.bool_]:
        """Which cells of the cube are solid, (r, r, r)."""
        return voxels.unpack(self.solid.packed, self.shape.resolution)

    @cached_property
    def mesh(self) -> trimesh.Trimesh:
        """Its closed surface, metres."""
        return packed_surface(self.solid.packed, self.shape)


@dataclass(frozen=True)
class Measured:
    """The measures of a solid."""

    complexity: float
    difficulty: float
    graph: reeb.ReebGraph


Evaluate = Callable[[Solid], Measured | str]


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

    The grasps are sampled with a generator named after the solid, so equal solids have equal
    measures wherever and whenever they are found, unless they are re-evaluated.
    """
    mesh = packed_surface(solid.packed, settings.shape)
    rng = generator(settings.seed, "difficulty", solid.id)
    try:
        place = measure_mesh(mesh, settings, settings.difficulty.grasps, rng)
        graph = reeb.extract(mesh, settings.similarity)
        return Measured(place.complexity, place.difficulty, graph)
    except RejectedError as error:
        return str(error)


def reevaluate(solid: Solid, settings: EvolutionParameters) -> float | str:
    """The difficulty of a challenger by other grasps, or the reason why it has none."""
    mesh = packed_surface(solid.packed, settings.shape)
    rng = generator(settings.seed, "newcomer", solid.id)
    try:
        return measure_mesh(mesh, settings, settings.evolution.reevaluation_grasps, rng).difficulty
    except RejectedError as error:
        return str(error)


class Step(NamedTuple):
    """Names one step."""

    epoch: int
    island: int
    step: int


class Island:
    """MAP-Elites on one archive, step by step: ask for candidates, measure them, tell."""

    def __init__(
        self,
        archive: Archive,
        settings: EvolutionParameters,
        epoch: int,
        island: int,
        rules: Rules = UNBOUND,
        mapper: Mapper = map,
        evaluate: Evaluate | None = None,
    ) -> None:
        """Start an epoch.

        Args:
            archive: Changed in place.
            settings: Everything about breeding and measuring.
            epoch: Number of the epoch.
            island: Number of the island.
            rules: What every shape must obey.
            mapper: An order-keeping `map`; where it runs does not change the result.
            evaluate: Gives the measures of a solid, or the reason why it has none; by default
                `measure`.
        """
        self._evaluate = evaluate or partial(measure, settings=settings)
        self.archive, self.outcomes = archive, Counter[str]()
        self._settings, self._rules, self._mapper = settings, rules, mapper
        self._step = Step(epoch, island, 0)

    def ask(self) -> list[Candidate]:
        """The offspring of the next step that are allowed and have voxels not seen before."""
        settings = self._settings
        offspring = breed(self.archive.elites, settings, *self._step)
        work = partial(express, settings=settings, rules=self._rules)
        solids = self._mapper(work, [each.genome for each in offspring])
        self._step = self._step._replace(step=self._step.step + 1)
        fresh: dict[str, Candidate] = {}
        for each, solid in zip(offspring, solids, strict=True):
            if isinstance(solid, str):
                self.outcomes[_kind(solid)] += 1
            elif solid.id in self.archive or solid.id in fresh:
                self.outcomes[KNOWN] += 1
            else:
                fresh[solid.id] = Candidate(each, solid, settings.shape)
        return list(fresh.values())

    def tell(self, candidates: Sequence[Candidate], results: Sequence[Measured | str]) -> None:
        """Add candidates to the archive.

        Args:
            candidates: From `ask`.
            results: The measures of each, or the reason why it has none.
        """
        elites = []
        for each, result in zip(candidates, results, strict=True):
            if isinstance(result, Measured):
                self.outcomes[EVALUATED] += 1
                elites.append(_elite(each, result, self._step.epoch))
            else:
                self.outcomes[_kind(result)] += 1
        self.archive.add(elites)

    def advance(self) -> Counter[str]:
        """One step: ask, measure and tell.

        Returns:
            How many offspring of this step were evaluated, empty, known already, or rejected for
            which reason.
        """
        before = self.outcomes.copy()
        candidates = self.ask()
        solids = [each.solid for each in candidates]
        results = list(self._mapper(self._evaluate, solids))
        if self._settings.evolution.reevaluation_grasps:
            results = _reevaluated(solids, results, self.archive, self._settings, self._mapper)
        self.tell(candidates, results)
        return self.outcomes - before


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
    run = Island(archive, settings, epoch, island, rules, mapper)
    rows: list[dict[str, Any]] = []
    steps, size = settings.evolution.steps_per_epoch, settings.evolution.population
    words = partial(_standing, rows)
    for number in progress(range(steps), "evaluations", steps, scale=size, state=words):
        outcomes = run.advance()
        scored = number % SCORED == SCORED - 1 or number == steps - 1
        row = Step(epoch, island, number)._asdict() | snapshot(archive, outcomes, scored)
        rows.append(row)
        if watch:
            watch(archive, rows)
    return pd.DataFrame(rows, columns=HISTORY.names), run.outcomes


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


def _reevaluated(
    solids: list[Solid],
    results: list[Measured | str],
    archive: Archive,
    settings: EvolutionParameters,
    mapper: Mapper,
) -> list[Measured | str]:
    """The results, with challengers for full cells re-evaluated by other grasps (ours)."""
    challengers = [
        index
        for index, result in enumerate(results)
        if isinstance(result, Measured) and archive.is_full(result.complexity, result.difficulty)
    ]
    solids_in_doubt = [solids[index] for index in challengers]
    difficulties = mapper(partial(reevaluate, settings=settings), solids_in_doubt)
    for index, difficulty in zip(challengers, difficulties, strict=True):
        first = results[index]
        if isinstance(first, Measured) and isinstance(difficulty, float):
            results[index] = replace(first, difficulty=difficulty)
        else:
            results[index] = difficulty
    return results


def _kind(reason: str) -> str:
    """A reason without its numbers."""
    return reason.partition(" (")[0]


def _elite(candidate: Candidate, measured: Measured, epoch: int) -> Elite:
    return Elite(
        id=candidate.id,
        genome=candidate.offspring.genome,
        voxels=candidate.solid.packed,
        complexity=measured.complexity,
        difficulty=measured.difficulty,
        graph=measured.graph,
        parents=candidate.offspring.parents,
        epoch=epoch,
    )
