"""The sections Summary and Rejected objects: contents of each dataset, and what was left out."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from egad.measures import MeasureSpace, coverage, filled_cells
from egad.report.axes import AxisPair
from egad.report.evolution import re_evaluation
from egad.report.page import Section, section_of
from egad.report.trials import Results


@dataclass(frozen=True)
class DatasetSummary:
    """A dataset in numbers.

    Attributes:
        kind: How its objects were made: `evolved`, `random` or `given`.
        objects: How many it has.
        filled_cells: Cells of the space with at least one object.
        coverage: Fraction of the archive slots that its objects fill.
        selected_coverage: The same by the graspability that evolution used for selection; NaN if
            there is none, or none from sampled grasps.
        certain: Fraction of the objects with a certain cell; NaN if it is not known.
        diversity: Lowest, mean and highest diversity; NaN if it has no objects.
        cut: Objects that lost bodies.
        dropped_volume: The largest fraction of its volume that an object lost with them.
        selected: Objects of its evaluation set.
        results: What detectors achieved on that set, by gripper.
    """

    kind: str
    objects: int
    filled_cells: int
    coverage: float
    selected_coverage: float
    certain: float
    diversity: tuple[float, float, float]
    cut: int
    dropped_volume: float
    selected: int
    results: Mapping[str, Results]


def summarize(
    kind: str,
    objects: pd.DataFrame,
    space: MeasureSpace,
    selected: int,
    results: Mapping[str, Results],
) -> DatasetSummary:
    """The numbers of a dataset.

    Args:
        kind: `evolved`, `random` or `given`.
        objects: Columns of `tables.objects.OBJECTS`.
        space: The cells.
        selected: Objects of its evaluation set.
        results: What detectors achieved on that set, by gripper.
    """
    diversity, moves = objects["diversity"], re_evaluation(objects, space)
    confidence = objects["cell_confidence"].dropna()
    return DatasetSummary(
        kind=kind,
        objects=len(objects),
        filled_cells=round(filled_cells(objects, space) * space.cells**2),
        coverage=coverage(objects, space),
        selected_coverage=moves.before if moves and len(confidence) else math.nan,
        certain=float((confidence >= space.confidence).mean()),
        diversity=(diversity.min(), diversity.mean(), diversity.max()),
        cut=int((objects["dropped_bodies"] > 0).sum()),
        dropped_volume=float(objects["dropped_volume"].max()),
        selected=selected,
        results=results,
    )


def section(
    datasets: Mapping[str, DatasetSummary], space: MeasureSpace, axes: AxisPair, capacity: int
) -> Section:
    """The summary of a run.

    Args:
        datasets: From `summarize`, by name; the numbers of the first are shown large.
        space: The cells.
        axes: What the axes of the space are called.
        capacity: How many objects an evaluation set can have.
    """
    values = {"space": space, "axes": axes, "capacity": capacity}
    return section_of("summary.html.j2", "Summary", datasets=datasets, **values)


def rejected_section(rejected: Mapping[str, pd.DataFrame]) -> Section:
    """The objects that were left out: how many for each reason, and all of them.

    Args:
        rejected: Columns of `tables.objects.REJECTED`, by dataset.
    """
    tables = {
        name: (rejection_counts(table), table.sort_values(["stage", "id"]).to_dict("records"))
        for name, table in rejected.items()
    }
    return section_of("rejected.html.j2", "Rejected", tables=tables)


def rejection_counts(rejected: pd.DataFrame) -> list[dict[str, Any]]:
    """Stage, reason and number of the objects left out, most frequent first."""
    counts = rejected.groupby(["stage", "reason"]).size().reset_index(name="count")
    ordered = counts.sort_values(["count", "stage", "reason"], ascending=[False, True, True])
    return [{str(key): value for key, value in row.items()} for row in ordered.to_dict("records")]
