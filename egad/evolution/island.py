"""One epoch of an island: vary elites, evaluate the offspring, update the archive."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import trimesh

from egad._util.arrays import Flags
from egad._util.display import facts_html
from egad._util.progress import progress
from egad._util.workers import Mapper
from egad.errors import UserError, most_common
from egad.evolution import voxels
from egad.evolution.archive import Archive, Elite, Refine
from egad.evolution.constraints import UNBOUND, Rules
from egad.evolution.evaluation import Evaluate, GenomeVoxels, Measured, express, measure, refine
from egad.evolution.growth import packed_surface
from egad.evolution.parameters import EvolutionParameters, Shape
from egad.evolution.variation import Offspring, breed
from egad.measures import coverage_of
from egad.tables.evolution import HISTORY, LINEAGE

EVALUATED, EMPTY, KNOWN = "evaluated", "empty", "known already"
UNMEASURED = 100  # objects without measures; this many end a search whose archive is empty
SCORED = 10  # the QD-score is computed once in this many steps
LINE = "coverage {coverage:.3f}, {elites} elites"


@dataclass(frozen=True, repr=False)
class Candidate:
    """A new shape that is to be measured."""

    offspring: Offspring
    solid: GenomeVoxels
    shape: Shape

    def __repr__(self) -> str:
        return f"Candidate({self.id!r})"

    def _repr_html_(self) -> str:
        facts = {"solid voxels": int(self.voxels.sum()), "resolution": self.shape.resolution}
        return facts_html(repr(self), facts, self.mesh)

    @property
    def id(self) -> str:
        """Hash of its voxels."""
        return self.solid.id

    @property
    def voxels(self) -> Flags:
        """Which cells of the cube are solid, (r, r, r)."""
        return voxels.unpack(self.solid.packed, self.shape.resolution)

    @cached_property
    def mesh(self) -> trimesh.Trimesh:
        """Its closed surface, metres."""
        return packed_surface(self.solid.packed, self.shape)


class Advance(NamedTuple):
    """What a step did."""

    outcomes: Counter[str]  # offspring that were evaluated, empty, known, or rejected, by reason
    refined: int  # how many of them were measured again
    accepted: list[Elite]  # objects that the archive accepted


class Epoch(NamedTuple):
    """What an epoch did."""

    history: pd.DataFrame  # the steps, with the columns of `tables.evolution.HISTORY`
    lineage: pd.DataFrame  # all that was accepted, even for a while: `tables.evolution.LINEAGE`
    outcomes: Counter[str]  # offspring that were evaluated, empty, known, or rejected, by reason


class Step(NamedTuple):
    """Identifies one step."""

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
        """Start an epoch of an archive, which is changed in place; `mapper` must preserve order."""
        self._evaluate = evaluate or partial(measure, settings=settings)
        once = evaluate or settings.measures.graspability or settings.evolution.estimator == "paper"
        self._refiner: Refine | None = None if once else self._refine
        self.archive, self.outcomes, self.refined = archive, Counter[str](), 0
        self._unmeasured = Counter[str]()
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

    def tell(
        self,
        candidates: Sequence[Candidate],
        results: Sequence[Measured | str],
        refine: Refine | None = None,
    ) -> None:
        """Add candidates from `ask` with their measures, or the reasons why they have none."""
        elites = []
        for each, result in zip(candidates, results, strict=True):
            if isinstance(result, Measured):
                self.outcomes[EVALUATED] += 1
                elites.append(
                    Elite(
                        id=each.id,
                        genome=each.offspring.genome,
                        voxels=each.solid.packed,
                        **vars(result),
                        parents=each.offspring.parents,
                        epoch=self._step.epoch,
                    )
                )
            else:
                self.outcomes[_kind(result)] += 1
        self.archive.add(elites, refine)

    def _refine(self, elites: list[Elite]) -> list[Elite | None]:
        self.refined += len(elites)
        return list(self._mapper(partial(refine, settings=self._settings), elites))

    def advance(self) -> Advance:
        """One step: ask, measure and tell; `UserError` if none of the first objects is measured."""
        outcomes, refined = self.outcomes.copy(), self.refined
        candidates = self.ask()
        results = list(self._mapper(self._evaluate, [each.solid for each in candidates]))
        self.tell(candidates, results, self._refiner)
        self._unmeasured.update(_kind(each) for each in results if isinstance(each, str))
        if not len(self.archive) and self._unmeasured.total() >= UNMEASURED:
            reasons = most_common(self._unmeasured)
            raise UserError(
                f"none of the first {self._unmeasured.total()} objects could be measured: {reasons}"
            )
        accepted = [self.archive[each.id] for each in candidates if each.id in self.archive]
        return Advance(self.outcomes - outcomes, self.refined - refined, accepted)


def evolve(
    archive: Archive,
    settings: EvolutionParameters,
    epoch: int,
    island: int,
    rules: Rules = UNBOUND,
    mapper: Mapper = map,
) -> Epoch:
    """The steps of one epoch of an island on its archive, which changes."""
    run = Island(archive, settings, epoch, island, rules, mapper)
    rows: list[dict[str, Any]] = []
    accepted: list[dict[str, Any]] = []
    steps, size = settings.evolution.steps, settings.evolution.population
    words = partial(_standing, rows)
    for number in progress(range(steps), "evaluations", steps, scale=size, state=words):
        done = run.advance()
        scored = number % SCORED == SCORED - 1 or number == steps - 1
        step = Step(epoch, island, number)._asdict()
        rows.append(step | snapshot(archive, done, scored))
        accepted += [step | elite.row() for elite in done.accepted]
    lineage = pd.DataFrame(accepted, columns=LINEAGE.names)
    return Epoch(pd.DataFrame(rows, columns=HISTORY.names), lineage, run.outcomes)


def snapshot(archive: Archive, done: Advance, scored: bool) -> dict[str, Any]:
    """What a step did: columns of `tables.evolution.HISTORY`, the QD-score only if `scored`."""
    counts, outcomes = archive.counts(), done.outcomes
    return {
        "offspring": outcomes.total(),
        "refined": done.refined,
        "evaluated": outcomes[EVALUATED],
        "empty": outcomes[EMPTY],
        "known": outcomes[KNOWN],
        "elites": len(archive),
        "coverage": coverage_of(counts, archive.space),
        "filled_cells": float((counts > 0).mean()),
        "qd_score": archive.qd_score if scored else math.nan,
        "cells": counts.astype(np.uint8).tobytes(),
    }


def _standing(rows: list[dict[str, Any]]) -> str:
    """Progress of the search; its QD-score is not computed at every step."""
    scored = (row["qd_score"] for row in reversed(rows) if not math.isnan(row["qd_score"]))
    score = next((f", QD-score {score:.1f}" for score in scored), "")
    return LINE.format(**rows[-1]) + score if rows else ""


def _kind(reason: str) -> str:
    """A reason without its numbers."""
    return reason.partition(" (")[0]
