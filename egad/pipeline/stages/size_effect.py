"""size-effect: grasp quality over object size, of meshes or of an evaluation set."""

import logging
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd

from egad._util.progress import progress
from egad._util.workers import workers
from egad.errors import RejectedError
from egad.exchange import read_mesh
from egad.geometry import units_doubt
from egad.measures import SizeEffectParameters
from egad.measures.size_effect import size_effect
from egad.pipeline.parameters import Evaluation, Input, Output, command
from egad.pipeline.stages.measure import repaired_mesh
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.grasping import SIZE_EFFECT

log = logging.getLogger(__name__)


@command("size-effect-eval")
def run(
    settings: SizeEffectParameters,
    evaluation: Evaluation,
    meshes: Annotated[Path, Input()],
    out: Annotated[Path, Output("D/size_effect/G.parquet", SIZE_EFFECT)],
) -> None:
    """Compute grasp quality over size for an easy, a medium and a hard evaluation object.

    Args:
        settings: Settings of this stage.
        evaluation: Evaluation set.
        meshes: Folder of the meshes of the dataset, in metres.
        out: Grasp quality over size for gripper G, of the easiest, the median and the hardest
            object of the evaluation set.
    """
    shown = spread(parquet.read(evaluation, EVAL49))
    files = {
        name: meshes / f"{label}.obj"
        for name, label in zip(shown["label"], shown["object_label"], strict=True)
    }
    table, reasons = curves(settings, files, "m", 1)
    for name, reason in reasons.items():
        log.warning("%s: %s", name, reason)
    parquet.write(table, SIZE_EFFECT, out)


def spread(evalset: pd.DataFrame) -> pd.DataFrame:
    """The easiest, the median and the hardest object of an evaluation set, in that order.

    Args:
        evalset: Columns of `tables.evaluation.EVAL49`. High difficulties are easy; ties are
            sorted by label.
    """
    ordered = evalset.sort_values(["difficulty", "label"], ascending=[False, True])
    last = len(ordered) - 1
    chosen = dict.fromkeys([0, last // 2, last] if len(ordered) else [])
    return ordered.iloc[list(chosen)].reset_index(drop=True)


def curves(
    settings: SizeEffectParameters, files: Mapping[str, Path], units: str | None, worker_count: int
) -> tuple[pd.DataFrame, dict[str, str]]:
    """Compute grasp quality over size for repaired meshes.

    Args:
        settings: Settings of this stage.
        files: Mesh files by name.
        units: Unit of their coordinates, None: as the files say; the result does not depend on it.
        worker_count: Processes; the result does not depend on it.

    Returns:
        Columns of `tables.grasping.SIZE_EFFECT`, meshes in the given order; and the reasons
        of the rejected meshes by name.
    """
    work = partial(_curve, units=units, settings=settings)
    with workers(max(1, min(worker_count, len(files)))) as mapper:
        done = list(progress(mapper(work, files.items()), "measuring", len(files)))
    if doubt := units_doubt({n: side for n, (_, side) in zip(files, done, strict=True)}, units):
        log.warning("%s", doubt)
    found = {name: item for name, (item, _) in zip(files, done, strict=True)}
    tables = [item for item in found.values() if not isinstance(item, str)]
    reasons = {name: item for name, item in found.items() if isinstance(item, str)}
    return pd.concat(tables) if tables else parquet.empty(SIZE_EFFECT), reasons


def _curve(
    item: tuple[str, Path], units: str | None, settings: SizeEffectParameters
) -> tuple[pd.DataFrame | str, float]:
    """The rows of a mesh, or the reason why there are none; and its longest side."""
    (name, path), longest = item, np.nan
    try:
        mesh = read_mesh(path, units)
        longest = float(mesh.extents.max())
        return size_effect(repaired_mesh(mesh, name), name, settings), longest
    except RejectedError as reason:
        return str(reason), longest
