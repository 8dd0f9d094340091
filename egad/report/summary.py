"""The sections Summary and Left out: the results of each dataset, and what was left out."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from egad.measures import MeasureSpace, coverage
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
    """A dataset in numbers, with results of detectors on its evaluation set by gripper."""

    objects: pd.DataFrame
    space: MeasureSpace
    evalset: pd.DataFrame | None
    results: Mapping[str, Results]
    listed: bool = False

    @property
    def selected(self) -> int:
        """Objects of the evaluation set."""
        return 0 if self.evalset is None else len(self.evalset)

    @property
    def coverage(self) -> float:
        """Fraction of the archive slots that the objects fill."""
        return coverage(self.objects, self.space)

    @property
    def corrected(self) -> bool:
        """Whether evolution selected the objects by other sampled grasps."""
        measured = self.objects["cell_confidence"].notna().any()
        return bool(measured and self.objects["archive_graspability"].notna().any())

    @property
    def certain(self) -> float:
        """Fraction of the objects with a certain cell; NaN if it is not known."""
        confidence = self.objects["cell_confidence"].dropna()
        return float((confidence >= self.space.confidence).mean())

    @property
    def cut(self) -> int:
        """Objects that lost bodies."""
        return int((self.objects["dropped_bodies"] > 0).sum())


def section(datasets: Mapping[str, DatasetSummary], capacity: int) -> Section:
    """The results of a run in numbers; an evaluation set has room for `capacity` objects."""
    return section_of("summary.html.j2", "Summary", datasets=datasets, capacity=capacity)


def left_out_section(rejected: Mapping[str, pd.DataFrame]) -> Section:
    """The objects that were left out, from `name_stages`: how many for which reason, and all."""
    tables = {
        name: (rejection_counts(table), table.to_dict("records"))
        for name, table in rejected.items()
    }
    return section_of("rejected.html.j2", "Left out", tables=tables, most=MOST_SHOWN)


def name_stages(rejected: pd.DataFrame) -> pd.DataFrame:
    """`tables.objects.REJECTED` in order; what objects were left out of replaces the stage."""
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
