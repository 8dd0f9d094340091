"""What a report is made of: tables, pictures and names, all in memory."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import pandas as pd

from egad.report.viewer import Scene


@dataclass(frozen=True)
class DatasetReport:
    """Everything known about one dataset. What was not made for it is absent.

    Attributes:
        objects: Columns of `tables.objects.OBJECTS`.
        rejected: Columns of `tables.objects.REJECTED`.
        pictures: PNG of each object, by its label; objects without one are shown without.
        evalset: Columns of `tables.evaluation.EVAL49`.
        evalset_pictures: Larger PNGs, by the label in the evaluation set; optional.
        grasps: Columns of `tables.grasping.GRASPS`, by gripper.
        scales: Columns of `tables.grasping.SCALES`, by gripper.
        size_effects: Columns of `tables.grasping.SIZE_EFFECT`, by gripper.
        manifests: Columns of `tables.evaluation.MANIFEST`, by gripper.
        trials: Columns of `tables.evaluation.TRIALS`, by gripper and policy.
        agreement: Columns of `tables.evaluation.AGREEMENT`, by gripper.
        scenes: Objects of the evaluation set with grasps of the first gripper.
        history: Columns of `tables.evolution.HISTORY`; only of a dataset evolved here.
    """

    objects: pd.DataFrame
    rejected: pd.DataFrame
    pictures: Mapping[str, bytes] = field(default_factory=dict)
    evalset: pd.DataFrame | None = None
    evalset_pictures: Mapping[str, bytes] = field(default_factory=dict)
    grasps: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    scales: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    size_effects: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    manifests: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    trials: Mapping[tuple[str, str], pd.DataFrame] = field(default_factory=dict)
    agreement: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    scenes: Sequence[Scene] = ()
    history: pd.DataFrame | None = None
