"""The MAP-Elites archive: at most a few elites per cell, kept for their diversity.

Source: EGAD, section III-D. Words as in pyribs: archive, cells, measures, elites, coverage.
"""

import heapq
import math
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from egad._util.arrays import Ints
from egad._util.display import Picture, draw, facts_html
from egad.errors import UserError
from egad.evolution.genome import Row
from egad.measures import Cell, MeasureSpace, cell_of, coverage_of
from egad.measures.reeb import Neighborhood, Similarity
from egad.measures.reeb import graph as reeb
from egad.tables import parquet
from egad.tables.evolution import EPOCH, GENOME

_MEASURED = ("complexity", "graspability", "graspability_std", "cell_confidence")


@dataclass(frozen=True, repr=False)
class Elite:
    """An object of the archive; elites of a cell compete by objective, then by diversity."""

    id: str
    genome: Row
    voxels: bytes
    complexity: float
    graspability: float
    graph: reeb.ReebGraph
    parents: tuple[str, ...]
    epoch: int
    graspability_std: float = math.nan
    cell_confidence: float = math.nan
    objective: float = 0.0

    def __repr__(self) -> str:
        measures = f"complexity {self.complexity:.4g}, graspability {self.graspability:.4g}"
        return f"Elite({self.id!r}: {measures})"

    def row(self) -> dict[str, Any]:
        """Columns of `tables.evolution.LINEAGE` and `EPOCH`: genome, measures and origin."""
        return {
            "id": self.id,
            **self.genome,
            **{name: getattr(self, name) for name in _MEASURED},
            "parents": list(self.parents),
            "epoch": self.epoch,
        }

    def is_certain(self, confidence: float) -> bool:
        """Whether its cell is as certain as required; True if its errors are not known."""
        return not self.cell_confidence < confidence


Refine = Callable[[list[Elite]], list[Elite | None]]


class Archive:
    """Elites in the cells of the space; no two of them have the same voxels."""

    def __init__(self, space: MeasureSpace, similarity: Similarity, threads: int = 1) -> None:
        """Start without elites; the number of threads for diversities changes no result."""
        self.space = space
        self._neighborhood = Neighborhood(similarity.weight, space.neighbors, threads)
        self._elites: dict[int, Elite] = {}
        self._cells: dict[int, Cell] = {}
        self._ids: dict[str, int] = {}

    def __len__(self) -> int:
        return len(self._elites)

    def __repr__(self) -> str:
        return f"Archive({len(self)} elites, coverage {self.coverage:.3f})"

    def _repr_html_(self) -> str:
        counts, space = self.counts(), self.space
        facts = {
            "elites": len(self),
            "coverage": f"{100 * self.coverage:.1f} %",
            "filled cells": f"{np.count_nonzero(counts)} of {counts.size}",
            "slots per cell": space.elites_per_cell,
            "range of the first measure": "{:g} to {:g}".format(*space.complexity_range),
            "range of the second measure": "{:g} to {:g}".format(*space.graspability_range),
        }
        return facts_html("Archive", facts)

    def plot(self, measures: tuple[str, str] | None = None) -> Picture:
        """Draw the map of the cells, with a picture of the oldest object of each.

        Args:
            measures: Names of the two measures, if they are your own. The first one ascends to the
                right, the second one downwards. By default, complexity and graspability.

        Returns:
            A picture that a notebook shows; `save("map.svg")` writes it.

        Raises:
            UserError: The names are not two strings.
        """
        two = isinstance(measures, tuple | list) and [type(name) for name in measures] == [str] * 2
        if measures is not None and not two:
            raise UserError(f"measures is {measures!r}; allowed: two names, such as ('a', 'b')")
        return draw("archive_map", "archive_map", self, measures)

    def __contains__(self, elite_id: str) -> bool:
        return elite_id in self._ids

    def __getitem__(self, elite_id: str) -> Elite:
        return self._elites[self._ids[elite_id]]

    @property
    def elites(self) -> list[Elite]:
        """All elites, in the order in which they were added."""
        return list(self._elites.values())

    @property
    def coverage(self) -> float:
        """The fraction of all slots that hold an elite (EGAD, Table III)."""
        return coverage_of(self.counts(), self.space)

    @property
    def qd_score(self) -> float:
        """The sum of the diversities of all elites (as pyribs; the objective is diversity)."""
        return sum(self._neighborhood.diversities(list(self._elites)))

    def counts(self) -> Ints:
        """How many elites each cell holds: (cells, cells), by difficulty, then complexity."""
        counts = np.zeros((self.space.cells, self.space.cells), np.int64)
        for complexity_cell, difficulty_cell in self._cells.values():
            counts[difficulty_cell, complexity_cell] += 1
        return counts

    def cell(self, elite: Elite) -> Cell:
        """The cell that an object belongs to: (complexity, difficulty)."""
        return cell_of(elite.complexity, elite.graspability, self.space)

    def add(self, candidates: Iterable[Elite], refine: Refine | None = None) -> None:
        """Insert objects that are not in the archive, then remove elites until every cell fits.

        From an overfull cell, uncertain elites are removed first, then those with the lowest
        objective, then the least diverse; each removal changes the diversities of the others.
        `refine` measures the candidates that their cell would keep more accurately, in order, or
        gives None for one that it rejects; they then compete in the cell of the refined measures.
        """
        fresh = {elite.id: elite for elite in candidates if elite.id not in self}
        indices = self._neighborhood.add([elite.graph for elite in fresh.values()])
        for index, elite in zip(indices, fresh.values(), strict=True):
            self._place(index, elite)
        if refine:
            self._refine(indices, refine)
        self._trim()

    def _place(self, index: int, elite: Elite) -> None:
        self._elites[index] = elite
        self._cells[index] = self.cell(elite)
        self._ids[elite.id] = index

    def _refine(self, fresh: list[int], refine: Refine) -> None:
        """Remove fresh objects that their cells would not keep, and refine the others."""
        losers = self._losers().intersection(fresh)
        for index in losers:
            self._remove(index)
        kept = [index for index in fresh if index not in losers]
        for index, elite in zip(kept, refine([self._elites[i] for i in kept]), strict=True):
            if elite is None:
                self._remove(index)
            else:
                self._place(index, elite)

    def _losers(self) -> set[int]:
        """The elites that overfull cells would lose if diversities stayed as they are."""
        counts = Counter(self._cells.values())
        excess = {cell: count - self.space.elites_per_cell for cell, count in counts.items()}
        losers = set()
        for *_, index in sorted(self._crowded(counts)):
            if excess[self._cells[index]] > 0:
                excess[self._cells[index]] -= 1
                losers.add(index)
        return losers

    def _trim(self) -> None:
        """Remove elites of overfull cells until every cell fits.

        With many others, a removal only raises diversities: those stored are lower bounds.
        """
        counts, limit = Counter(self._cells.values()), self.space.elites_per_cell
        queue = self._crowded(counts)
        heapq.heapify(queue)
        while queue:
            certain, objective, value, name, index = heapq.heappop(queue)
            if counts[self._cells[index]] <= limit:
                continue
            now = self._neighborhood.diversity(index)
            if now != value:
                heapq.heappush(queue, (certain, objective, now, name, index))
                continue
            counts[self._cells[index]] -= 1
            self._remove(index)
            if len(self) <= self.space.neighbors + 1:
                queue = self._crowded(counts)
                heapq.heapify(queue)

    def _crowded(self, counts: Counter[Cell]) -> list[tuple[bool, float, float, str, int]]:
        """Elites of overfull cells with their sort keys: the first ones are removed first."""
        limit, confidence = self.space.elites_per_cell, self.space.confidence
        crowded = [index for index, cell in self._cells.items() if counts[cell] > limit]
        values = self._neighborhood.diversities(crowded)
        elites = [self._elites[index] for index in crowded]
        certain = [elite.is_certain(confidence) for elite in elites]
        objectives = [elite.objective for elite in elites]
        names = [elite.id for elite in elites]
        return list(zip(certain, objectives, values, names, crowded, strict=True))

    def _remove(self, index: int) -> None:
        del self._ids[self._elites.pop(index).id]
        del self._cells[index]
        self._neighborhood.remove(index)

    def to_frame(self) -> pd.DataFrame:
        """The archive as a table (`EPOCH`), by cell, then slot; slot 0 is the most diverse one."""
        rows = []
        diversities = self._neighborhood.diversities(list(self._elites))
        for (index, elite), diversity in zip(self._elites.items(), diversities, strict=True):
            complexity_cell, difficulty_cell = self._cells[index]
            rows.append(
                {
                    **elite.row(),
                    "voxels": elite.voxels,
                    "diversity": diversity,
                    "complexity_cell": complexity_cell,
                    "difficulty_cell": difficulty_cell,
                    "graph": reeb.pack(elite.graph),
                }
            )
        if not rows:
            return parquet.empty(EPOCH)
        cell = ["difficulty_cell", "complexity_cell"]
        frame = pd.DataFrame(rows).sort_values(
            [*cell, "diversity", "id"], ascending=[True, True, False, True], ignore_index=True
        )
        return frame.assign(slot=frame.groupby(cell).cumcount())

    def to_ribs_frame(self) -> pd.DataFrame:
        """The elites with the columns of a pyribs `ArchiveDataFrame`: see `ribs_frame`."""
        return ribs_frame(self.to_frame(), self.space)


def elites_of(frame: pd.DataFrame) -> list[Elite]:
    """The elites of a table with the columns of `tables.evolution.EPOCH`, in its order."""
    return [
        Elite(
            id=row["id"],
            genome={name: row[name] for name in GENOME.names},
            voxels=row["voxels"],
            graph=reeb.unpack(row["graph"]),
            parents=tuple(row["parents"]),
            epoch=row["epoch"],
            **{name: row[name] for name in _MEASURED},
        )
        for row in parquet.records(frame)
    ]


def merge(
    frames: Iterable[pd.DataFrame], space: MeasureSpace, similarity: Similarity, threads: int = 1
) -> pd.DataFrame:
    """One archive of the elites of all islands, in order, from and to tables as `EPOCH`."""
    archive = Archive(space, similarity, threads)
    archive.add(elite for frame in frames for elite in elites_of(frame))
    return archive.to_frame()


def ribs_frame(archive: pd.DataFrame, space: MeasureSpace) -> pd.DataFrame:
    """The elites of an archive or `Dataset.table` as a pyribs `ArchiveDataFrame`, for its tools.

    `index` is the cell, along complexity, then graspability, from the low ends; cells may repeat.
    """
    rows = space.cells - 1 - archive["difficulty_cell"].to_numpy()  # the low end is hard
    shape = (space.cells, space.cells)
    return pd.DataFrame(
        {
            "index": np.ravel_multi_index((archive["complexity_cell"].to_numpy(), rows), shape),
            "objective": archive["diversity"].to_numpy(),
            "measures_0": archive["complexity"].to_numpy(),
            "measures_1": archive["graspability"].to_numpy(),
            "id": archive["id"].to_numpy(),
        }
    )
