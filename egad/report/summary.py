"""The sections Summary and Left out: the results of each dataset, and what was left out."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from egad.measures import MeasureSpace, coverage
from egad.report.evolution import re_evaluation
from egad.report.page import Section, section_of
from egad.report.trials import Results

MOST_SHOWN = 20  # objects that were left out; more are folded
LEFT_OUT_OF = {
    "postprocess": "the dataset",
    "select-eval": "the evaluation set",
    "rescale": "scaling",
    "grasp-label": "labelled grasps",
    "bundle": "simulation",
    "print-export": "printing",
}


@dataclass(frozen=True)
class DatasetSummary:
    """A dataset in numbers.

    Attributes:
        objects: How many it has.
        listed: Whether they are shown one by one rather than on a map.
        coverage: Fraction of the archive slots that its objects fill.
        selected_coverage: The same by the graspability that evolution used for selection; NaN if
            there is none, or none from sampled grasps.
        certain: Fraction of the objects with a certain cell; NaN if it is not known.
        cut: Objects that lost bodies.
        dropped_volume: The largest fraction of its volume that an object lost with them.
        selected: Objects of its evaluation set.
        results: What detectors achieved on that set, by gripper.
    """

    objects: int
    listed: bool
    coverage: float
    selected_coverage: float
    certain: float
    cut: int
    dropped_volume: float
    selected: int
    results: Mapping[str, Results]


def summarize(
    objects: pd.DataFrame,
    space: MeasureSpace,
    selected: int,
    results: Mapping[str, Results],
    *,
    listed: bool = False,
) -> DatasetSummary:
    """The numbers of a dataset.

    Args:
        objects: Columns of `tables.objects.OBJECTS`.
        space: The cells.
        selected: Objects of its evaluation set.
        results: What detectors achieved on that set, by gripper.
        listed: Whether the objects are shown one by one rather than on a map.
    """
    moves = re_evaluation(objects, space)
    confidence = objects["cell_confidence"].dropna()
    return DatasetSummary(
        objects=len(objects),
        listed=listed,
        coverage=coverage(objects, space),
        selected_coverage=moves.before if moves and len(confidence) else math.nan,
        certain=float((confidence >= space.confidence).mean()),
        cut=int((objects["dropped_bodies"] > 0).sum()),
        dropped_volume=float(objects["dropped_volume"].max()),
        selected=selected,
        results=results,
    )


def section(datasets: Mapping[str, DatasetSummary], space: MeasureSpace, capacity: int) -> Section:
    """The results of a run in numbers.

    Args:
        datasets: From `summarize`, by name.
        space: The cells.
        capacity: How many objects an evaluation set can have.
    """
    values = {"space": space, "capacity": capacity}
    return section_of("summary.html.j2", "Summary", datasets=datasets, **values)


def left_out_section(rejected: Mapping[str, pd.DataFrame]) -> Section:
    """The objects that were left out: how many of what for which reason, and all of them.

    Args:
        rejected: As from `of_what`, by dataset.
    """
    tables = {
        name: (rejection_counts(table), table.to_dict("records"))
        for name, table in rejected.items()
    }
    return section_of("rejected.html.j2", "Left out", tables=tables, most=MOST_SHOWN)


def of_what(rejected: pd.DataFrame) -> pd.DataFrame:
    """Rejected objects in order, with what they were left out of in place of the stage.

    Args:
        rejected: Columns of `tables.objects.REJECTED`; a stage may be followed by a gripper.
    """
    stages = [stage.partition(" ") for stage in rejected["stage"]]
    words = [
        LEFT_OUT_OF.get(stage, stage) + (f" for {gripper}" if gripper else "")
        for stage, _, gripper in stages
    ]
    return rejected.assign(stage=words).sort_values(["id", "stage"], ignore_index=True)


def rejection_counts(rejected: pd.DataFrame) -> list[dict[str, Any]]:
    """Stage, reason and number of the objects left out, most frequent first."""
    counts = rejected.groupby(["stage", "reason"]).size().reset_index(name="count")
    ordered = counts.sort_values(["count", "stage", "reason"], ascending=[False, True, True])
    return [{str(key): value for key, value in row.items()} for row in ordered.to_dict("records")]
