"""An atlas: the failures of a detector in a map of complexity and graspability."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from egad._util.display import Picture, draw, facts_html
from egad.bench.failures.evidence import ObjectVerdict
from egad.bench.failures.parameters import FailureParameters
from egad.bench.failures.search import elite_of, empty_archive
from egad.bench.failures.store import Found
from egad.bench.stats import Rate
from egad.evolution import Shape
from egad.measures import MeasureSpace
from egad.objects import Dataset, dataset_of
from egad.tables import parquet
from egad.tables.failures import EXAMINED, FAILURE_ATTEMPTS, FAILURES, RESULTS

CELL = ["complexity_cell", "difficulty_cell"]


class FailureAtlas:
    """Failures of a detector, the other examined objects, and all attempts.

    Attributes:
        table: One row per failure, columns of `tables.failures.FAILURES`.
        examined: One row per object that the search looked at, columns of
            `tables.failures.EXAMINED`.
        attempts: One row per simulated grasp, columns of `tables.failures.FAILURE_ATTEMPTS`.
        shape: How voxels became meshes.
        settings: Settings of the search, if known: gripper, scale rule, approach, engines, cells.
        detector: Name of the detector, if known.
    """

    def __init__(
        self,
        table: pd.DataFrame,
        examined: pd.DataFrame,
        attempts: pd.DataFrame,
        shape: Shape | None = None,
        settings: FailureParameters | None = None,
        detector: str = "",
    ) -> None:
        """Wrap tables."""
        self.table = table.reset_index(drop=True)
        self.examined, self.attempts = examined, attempts
        self.shape = shape or Shape()
        self.settings, self.detector = settings, detector

    def __len__(self) -> int:
        return len(self.table)

    def __repr__(self) -> str:
        spent = int(self.examined["attempts"].sum())
        verdicts = self.examined["verdict"].value_counts()
        looked = ", ".join(f"{count} {name}" for name, count in verdicts.items())
        return (
            f"FailureAtlas({len(self)} failures in {self.cells} cells, {spent} attempts; "
            f"{len(self.examined)} objects: {looked})"
        )

    def _repr_html_(self) -> str:
        """A summary in numbers, for notebooks; `plot` draws the map."""
        verdicts = self.examined["verdict"].value_counts()
        facts = {
            "failures": len(self),
            "cells with a failure": self.cells,
            "attempts": int(self.examined["attempts"].sum()),
            "failures among the objects examined": self.failure_rate(),
            **{str(name).replace("_", " "): int(count) for name, count in verdicts.items()},
        }
        return facts_html("Atlas of failures", facts)

    @property
    def cells(self) -> int:
        """Cells with a failure."""
        return len(self.table[CELL].drop_duplicates())

    def failure_rate(self) -> Rate:
        """Failures among the objects with attempts in this search, not among all objects."""
        tried = self.examined[self.examined["attempts"] > 0]
        return Rate(int((tried["verdict"] == ObjectVerdict.FAILURE).sum()), len(tried))

    @property
    def objects(self) -> Dataset:
        """The failures as a dataset with voxels and genomes; UserError if there are none."""
        return dataset_of(self.table, self.shape)

    def plot(self) -> Picture:
        """Draw the map of the failures: differences by complexity and graspability.

        Returns:
            A picture that a notebook shows; `save("map.svg")` writes it.

        Raises:
            UserError: There are no failures.
        """
        space = MeasureSpace() if self.settings is None else self.settings.breeding.space
        return draw("failure_map", "failure_map", self.table, self.examined, space)

    def save(self, place: str | Path) -> None:
        """Write the three tables; `egad.load("FOLDER/failures.parquet")` reads the failures.

        Args:
            place: A folder, for `failures.parquet`, `examined.parquet` and `attempts.parquet`; or
                a file `P.parquet` for the failures, next to which the other tables are written as
                `P.examined.parquet` and `P.attempts.parquet`, as in the results of a run.
        """
        failures, examined, attempts = _files(Path(place))
        notes = {"shape": self.shape.model_dump(mode="json"), "detector": self.detector}
        if self.settings is not None:
            notes["settings"] = self.settings.model_dump(mode="json")
        parquet.write(self.table, FAILURES, failures, notes)
        parquet.write(self.examined, EXAMINED, examined, notes)
        parquet.write(self.attempts, FAILURE_ATTEMPTS, attempts)

    @classmethod
    def load(cls, place: str | Path) -> "FailureAtlas":
        """Read an atlas written by `save`, `egad failures` or a run.

        Args:
            place: A folder or a file, as for `save`.

        Raises:
            TableError: A table is missing or damaged.
        """
        failures, examined, attempts = _files(Path(place))
        notes = parquet.notes(failures)
        settings = notes.get("settings")
        return cls(
            parquet.read(failures, FAILURES),
            parquet.read(examined, EXAMINED),
            parquet.read(attempts, FAILURE_ATTEMPTS),
            Shape.model_validate(notes.get("shape", {})),
            None if settings is None else FailureParameters.model_validate(settings),
            notes.get("detector", ""),
        )


def _files(place: Path) -> tuple[Path, Path, Path]:
    """Where the failures, the examined objects and the attempts are."""
    if place.suffix == ".parquet":
        return place, place.with_suffix(".examined.parquet"), place.with_suffix(".attempts.parquet")
    names = ("failures", "examined", "attempts")
    failures, examined, attempts = (place / f"{name}.parquet" for name in names)
    return failures, examined, attempts


def merge(shards: Sequence[Found], settings: FailureParameters) -> pd.DataFrame:
    """One archive of the failures of all shards, without columns of `tables.failures.EXPLAINED`."""
    archive = empty_archive(settings)
    examined = pd.concat([each.examined for each in shards], ignore_index=True)
    failures = examined[examined["verdict"] == ObjectVerdict.FAILURE].drop_duplicates("id")
    archive.add(elite_of(row) for row in parquet.records(failures))
    kept = archive.to_frame().drop(columns="graph")
    return kept.merge(failures[["id", *RESULTS.names]], on="id", how="left", sort=False)
