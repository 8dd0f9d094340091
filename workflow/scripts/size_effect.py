"""size-effect: grasp quality over size of an easy, a medium and a hard evaluation object."""

import logging
from pathlib import Path

import pandas as pd

from egad.measures import SizeEffectParameters
from egad.measures.size_effect import curves
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.grasping import SIZE_EFFECT
from egad_workflow.job import run_job

log = logging.getLogger(__name__)


def run(settings: SizeEffectParameters, evaluation: Path, meshes: Path, size_effect: Path) -> None:
    """Compute grasp quality over size for an easy, a medium and a hard evaluation object."""
    shown = spread(parquet.read(evaluation, EVAL49))
    files = {
        name: meshes / f"{label}.obj"
        for name, label in zip(shown["label"], shown["object_label"], strict=True)
    }
    table, reasons = curves(settings, files, "m", 1)
    for name, reason in reasons.items():
        log.warning("%s: %s", name, reason)
    parquet.write(table, SIZE_EFFECT, size_effect)


def spread(evalset: pd.DataFrame) -> pd.DataFrame:
    """The easiest (highest graspability), median and hardest object, in order; ties by label."""
    ordered = evalset.sort_values(["graspability", "label"], ascending=[False, True])
    last = len(ordered) - 1
    chosen = dict.fromkeys([0, last // 2, last] if len(ordered) else [])
    return ordered.iloc[list(chosen)].reset_index(drop=True)


if __name__ == "__main__":
    run_job(run)
