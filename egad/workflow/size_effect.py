"""Grasp quality over object size, of mesh files."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

import pandas as pd

from egad._util.progress import progress
from egad._util.workers import workers
from egad.measures import SizeEffectParameters
from egad.measures.size_effect import size_effect
from egad.tables import parquet
from egad.tables.grasping import SIZE_EFFECT
from egad.workflow.mesh_files import use_mesh, warn_of_units
from egad.workflow.repair import repaired_mesh


def curves(
    settings: SizeEffectParameters, files: Mapping[str, Path], units: str | None, worker_count: int
) -> tuple[pd.DataFrame, dict[str, str]]:
    """Compute grasp quality over size for repaired meshes, and the reasons of rejected ones.

    The columns are `tables.grasping.SIZE_EFFECT`, meshes in the given order. Units, as stated in
    the files if None, do not affect the result.
    """
    work = partial(_curve, units=units, settings=settings)
    with workers(max(1, min(worker_count, len(files)))) as mapper:
        done = list(progress(mapper(work, files.items()), "measuring", len(files)))
    warn_of_units({name: side for name, (_, side) in zip(files, done, strict=True)}, units)
    found = {name: item for name, (item, _) in zip(files, done, strict=True)}
    tables = [item for item in found.values() if not isinstance(item, str)]
    reasons = {name: item for name, item in found.items() if isinstance(item, str)}
    return pd.concat(tables) if tables else parquet.empty(SIZE_EFFECT), reasons


def _curve(
    item: tuple[str, Path], units: str | None, settings: SizeEffectParameters
) -> tuple[pd.DataFrame | str, float]:
    """The rows of a mesh, or the reason why there are none; and its longest side."""
    name, path = item
    return use_mesh(
        path, units, lambda mesh: size_effect(repaired_mesh(mesh, name), name, settings)
    )
