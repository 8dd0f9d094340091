"""The search for failures: MAP-Elites whose objective is how much worse a detector is.

Objects come from three sources: an archive that already spans complexity and graspability, random
genomes, and children of the objects at which the detector does worst. The source that has given
most failures per attempt gets three of five steps, each of the others one. A cell that is full of
failures is closed: no attempts are spent there.
"""

import logging
import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import pandas as pd
import trimesh

from egad.bench.failures.evidence import Examined, ObjectVerdict, counts_of
from egad.bench.failures.examine import Examination
from egad.bench.failures.models import scaled_to, surface_of
from egad.bench.failures.parameters import FailureParameters, FailureSearch
from egad.bench.failures.store import NOTHING, Found
from egad.detectors import Detector, FailureMonitor
from egad.errors import RejectedError
from egad.evolution import UNBOUND, Archive, Elite, Row, breed, express
from egad.measures import Cell, cell_of, measure_mesh
from egad.measures.graspability import graspability
from egad.measures.reeb import graph as reeb
from egad.random import generator
from egad.tables import parquet
from egad.tables.evolution import GENOME
from egad.tables.failures import EXAMINED

log = logging.getLogger(__name__)

LITTER = 10  # objects per step
PROMISING = 0.5  # minimum estimated difference of parents
SOURCES = ("archive", "child", "random")
TURNS = 5  # steps of which each source except the best gets one
EXPECTED = (1, 150)  # failures and attempts of a source, before anything is known
IDLE = 500  # steps in a row without an attempt after which a search ends
DOUBTFUL = 20  # attempts without any success of the detector after which a warning is logged


@dataclass(frozen=True)
class Target:
    """An object that may be examined."""

    id: str  # hash of its voxels
    source: str  # archive, child or random
    genome: Row  # columns of `tables.evolution.GENOME`
    voxels: bytes  # as archives keep them
    parents: tuple[str, ...]
    complexity: float = math.nan  # NaN if it was not measured
    graspability: float = math.nan  # NaN if it was not measured


class Search:
    """One shard of a search, which continues from earlier results."""

    def __init__(
        self,
        archive: pd.DataFrame,
        detect: Detector,
        settings: FailureParameters,
        shard: int = 0,
        before: Found = NOTHING,
        report: Callable[[int], object] = int,
    ) -> None:
        """Continue from the whole steps before; `report` is called with 1 after every attempt."""
        self._detect, self._settings, self._shard = detect, settings, shard
        self._report = report
        self._targets = _shuffled(archive, settings, shard)
        self.archive = empty_archive(settings)
        known = before.attempts[before.attempts["who"] == "detector"]
        has_worked = bool((known["failure"] == "").any())
        self._monitor = FailureMonitor(None, keep_going=has_worked, remedy="")
        self._asked, self._successes = len(known), int(known["success"].sum())
        self._seen: set[str] = set()
        self._failures: set[str] = set()
        self._spent, self._step, self._idle, self._screened = 0, 0, 0, 0
        self._yields = {source: Counter[str]() for source in SOURCES}
        for row in parquet.records(before.examined):
            self._remember(row)
            self._idle = 0 if row["attempts"] else self._idle + row["step"] + 1 - self._step
            self._step = row["step"] + 1
        screened = set(before.examined.loc[before.examined["source"] == "archive", "id"])
        last = max((n for n, each in enumerate(self._targets) if each.id in screened), default=-1)
        self._screened = LITTER * (last // LITTER + 1)

    @property
    def spent(self) -> int:
        """Attempts so far."""
        return self._spent

    def steps(self) -> Iterator[Found]:
        """Results of each further step, until all attempts are spent or nothing is left to try."""
        budget = attempts_of(self._shard, self._settings.failures)
        while self._spent < budget and self._idle < IDLE:
            targets = self._next_targets()
            if targets is None:
                return
            rows, tables, spent = [], [], self._spent
            for target in targets:
                if target.id in self._seen or self._spent >= budget:
                    continue
                row, attempts = self._consider(target)
                self._remember(row)
                rows.append(row)
                tables.append(attempts)
            self._step += 1
            self._idle = 0 if self._spent > spent else self._idle + 1
            if rows:
                yield Found(
                    pd.DataFrame(rows, columns=EXAMINED.names), pd.concat(tables, ignore_index=True)
                )

    def _next_targets(self) -> list[Target] | None:
        """The objects of a step; None if there is nothing left to try."""
        left = self._targets[self._screened : self._screened + LITTER]
        elites = self.archive.elites
        promising = [each for each in elites if each.objective >= PROMISING]
        match self._settings.failures.strategy:
            case "screening":
                source = "archive"
            case "random":
                source = "random"
            case "mutation":
                return self._children(self._targets)
            case "evolution":
                source = self._source({"archive": bool(left), "child": bool(promising)})
        if source == "archive":
            self._screened += len(left)
            return left or None
        return self._children(promising if source == "child" else [])

    def _source(self, can: dict[str, bool]) -> str:
        """Source of the next objects: the best available one, or another one whose turn it is."""
        failures, attempts = EXPECTED
        order = sorted(
            (source for source in SOURCES if can.get(source, True)),
            key=lambda source: (
                -(self._yields[source]["failures"] + failures)
                / (self._yields[source]["attempts"] + attempts)
            ),
        )
        return order[max(self._step % TURNS - (TURNS - len(order)), 0)]

    def _children(self, parents: Sequence[Target | Elite]) -> list[Target]:
        """Children of some parents, or random genomes."""
        settings = self._settings.breeding
        litter = settings.evolution.model_copy(update={"population": LITTER})
        settings = settings.model_copy(update={"evolution": litter})
        children = []
        for each in breed(parents, settings, self._shard, self._step):
            solid = express(each.genome, settings, UNBOUND)
            if not isinstance(solid, str):
                source = "child" if each.parents else "random"
                children.append(Target(solid.id, source, each.genome, solid.packed, each.parents))
        return children

    def _consider(self, target: Target) -> tuple[dict[str, Any], pd.DataFrame]:
        """Measure an object and, if its cell is not full of failures, examine it."""
        nothing = NOTHING.attempts
        try:
            mesh = surface_of(target.voxels, self._settings)
            complexity, value = self._measures(target, mesh)
        except RejectedError as problem:
            found = Examined(ObjectVerdict.NOT_MEASURED, str(problem), nothing)
            return self._row(target, (math.nan, math.nan), None, found), nothing
        cell = cell_of(complexity, value, self.archive.space)
        if self._is_closed(cell):
            found = Examined(ObjectVerdict.CELL_FULL, "", nothing)
            return self._row(target, (complexity, value), cell, found), nothing
        scaled = scaled_to(mesh, self._settings)
        found = Examination(scaled, target.id, self._detect, self._settings, self._report).run()
        self._look_after_detector(found.attempts[found.attempts["who"] == "detector"])
        graph = b""
        if found.objective > 0:
            graph = reeb.pack(reeb.extract(mesh, self._settings.breeding.similarity))
        return self._row(target, (complexity, value), cell, found, graph), found.attempts

    def _look_after_detector(self, attempts: pd.DataFrame) -> None:
        """End the search if the detector fails in every attempt; warn if it never succeeds."""
        self._monitor.check(attempts)
        few = self._asked < DOUBTFUL
        self._asked += len(attempts)
        self._successes += int(attempts["success"].sum())
        if few and self._asked >= DOUBTFUL and not self._successes and self._shard == 0:
            log.warning("the detector succeeded in none of the first %d attempts", self._asked)

    def _measures(self, target: Target, mesh: trimesh.Trimesh) -> tuple[float, float]:
        """Complexity and graspability, as measured for the archive."""
        if math.isfinite(target.graspability):
            return target.complexity, target.graspability
        settings = self._settings.breeding
        rng = generator(settings.seed, "difficulty", target.id)

        most = settings.evolution.max_candidates
        estimate = partial(graspability, settings=settings, max_candidates=most, rng=rng)
        values = measure_mesh(mesh, settings, estimate)
        return values.complexity, values.graspability

    def _is_closed(self, cell: Cell) -> bool:
        """Whether a cell is full of failures."""
        there = Counter(
            self.archive.cell(self.archive[name]) for name in self._failures if name in self.archive
        )
        return there[cell] >= self._settings.failures.elites_per_cell

    def _row(
        self,
        target: Target,
        measures: tuple[float, float],
        cell: Cell | None,
        found: Examined,
        graph: bytes = b"",
    ) -> dict[str, Any]:
        """Columns of `tables.failures.EXAMINED`."""
        across, down = cell or (-1, -1)
        return {
            "id": target.id,
            "shard": self._shard,
            "step": self._step,
            "source": target.source,
            "parents": list(target.parents),
            "verdict": found.verdict.value,
            "reason": found.reason,
            "complexity": measures[0],
            "graspability": measures[1],
            "complexity_cell": across,
            "difficulty_cell": down,
            "attempts": len(found.attempts),
            "objective": found.objective,
            **counts_of(found.attempts),
            **target.genome,
            "voxels": target.voxels if len(found.attempts) else b"",
            "graph": graph,
        }

    def _remember(self, row: dict[str, Any]) -> None:
        """Take a row into account, also one of an earlier run."""
        self._seen.add(row["id"])
        self._spent += row["attempts"]
        self._yields[row["source"]]["attempts"] += row["attempts"]
        self._yields[row["source"]]["failures"] += row["verdict"] == ObjectVerdict.FAILURE
        if row["verdict"] == ObjectVerdict.FAILURE:
            self._failures.add(row["id"])
        if row["objective"] > 0:
            self.archive.add([elite_of(row)])


def attempts_of(shard: int, search: FailureSearch) -> int:
    """Number of attempts of a shard; the last object may need some more."""
    every, more = divmod(search.attempts, search.shards)
    return every + (shard < more)


def empty_archive(settings: FailureParameters) -> Archive:
    """An archive for objects with differences; the settings give its cells and their capacity."""
    update = {"elites_per_cell": settings.failures.elites_per_cell}
    space = settings.breeding.space.model_copy(update=update)
    return Archive(space, settings.breeding.similarity)


def elite_of(row: dict[str, Any]) -> Elite:
    """A row with the columns of `tables.failures.EXAMINED` as an elite; failures come first."""
    return Elite(
        id=row["id"],
        genome={name: row[name] for name in GENOME.names},
        voxels=row["voxels"],
        complexity=row["complexity"],
        graspability=row["graspability"],
        graph=reeb.unpack(row["graph"]),
        parents=tuple(row["parents"]),
        epoch=row["step"],
        objective=row["objective"] + (row["verdict"] == ObjectVerdict.FAILURE),
    )


def _shuffled(archive: pd.DataFrame, settings: FailureParameters, shard: int) -> list[Target]:
    """The objects of an archive that a shard begins with, in random order."""
    order = generator(settings.seed, "failure order").permutation(len(archive))
    chosen = archive.iloc[order[shard :: settings.failures.shards]]
    return [
        Target(
            row["id"],
            "archive",
            {name: row[name] for name in GENOME.names},
            row["voxels"],
            tuple(row["parents"]),
            row["complexity"],
            row["graspability"],
        )
        for row in parquet.records(chosen)
    ]
