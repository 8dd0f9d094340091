"""How grasp quality changes with the size of an object.

The figure is EGAD's (Morrison, Corke and Leitner, RA-L 2020): percentiles of grasp quality over the
size of an object relative to its gripper. Repetitions and the share of candidates are ours.
"""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import trimesh

from egad._util.arrays import Floats
from egad._util.progress import progress
from egad._util.workers import workers
from egad.errors import NoGraspError
from egad.geometry import RayCaster, box_sides, center_of_mass
from egad.geometry.repair import repaired_mesh
from egad.grasps import ferrari_canny, sample_contacts
from egad.grasps.samplers import draw_grasps
from egad.grippers import ANTIPODAL
from egad.io import use_mesh, warn_of_units
from egad.measures.parameters import SizeEffectParameters
from egad.measures.percentile import percentile
from egad.random import generator
from egad.tables import parquet
from egad.tables.grasping import SIZE_EFFECT


def size_effect(mesh: trimesh.Trimesh, name: str, settings: SizeEffectParameters) -> pd.DataFrame:
    """Grasp quality of a closed mesh as its smallest side grows (`tables.grasping.SIZE_EFFECT`)."""
    wanted, opening = settings.size_effect, settings.gripper.opening
    side = float(box_sides(mesh)[0])
    rows: list[dict[str, Any]] = []
    for fraction in wanted.fractions:
        factor = fraction * opening / side
        scaled = trimesh.Trimesh(np.asarray(mesh.vertices) * factor, mesh.faces, process=False)
        caster = RayCaster(scaled)
        for repeat in range(wanted.repeats):
            rng = generator(settings.seed, "size-effect", name, f"{fraction:g}", repeat)
            known = {"name": name, "fraction": fraction, "repeat": repeat}
            qualities, candidates, possible = _qualities(caster, settings, rng)
            known |= {"candidates": candidates, "possible": possible, "grasps": len(qualities)}
            for percent in wanted.percentiles:
                value = percentile(qualities, percent) if len(qualities) else np.nan
                rows.append(known | {"percentile": percent, "quality": value})
    return pd.DataFrame(rows, columns=SIZE_EFFECT.names)


def _qualities(
    caster: RayCaster, settings: SizeEffectParameters, rng: np.random.Generator
) -> tuple[Floats, int, int]:
    """Qualities of grasps, and the numbers of candidates, and of those that are possible.

    With another sampler than the antipodal one, a cup that does not seal has the quality 0.
    """
    gripper, wanted = settings.gripper, settings.size_effect.grasps
    com = center_of_mass(caster.mesh)
    if gripper.grasps_with != ANTIPODAL:
        robust, density = settings.robust, settings.density
        try:
            quality = draw_grasps(
                caster.mesh, com, gripper, wanted, rng, robust=robust, density=density
            ).quality
        except NoGraspError:
            quality = np.empty(0)
        return quality, wanted, len(quality)
    grasps, statistics = sample_contacts(caster, gripper.opening, wanted, settings.sampling, rng)
    qualities = ferrari_canny(
        grasps.points, grasps.normals, grasps.axes, com, **settings.quality.model_dump()
    )
    possible = (
        statistics.candidates - statistics.too_wide - statistics.not_antipodal - statistics.blocked
    )
    return qualities, statistics.candidates, possible


def summarize(table: pd.DataFrame) -> pd.DataFrame:
    """Means and spread over the repetitions, for each name, fraction and percentile, in this order.

    `mean`, `low` and `high` are the quality over those that found grasps, `found` the fraction of
    these; `share` is that of the candidates that are possible.
    """
    groups = table.groupby(["name", "fraction", "percentile"], sort=False)
    numbers = groups.agg(
        mean=("quality", "mean"),
        low=("quality", "min"),
        high=("quality", "max"),
        grasps=("grasps", "mean"),
        found=("quality", "count"),
        repeats=("quality", "size"),
        candidates=("candidates", "sum"),
        possible=("possible", "sum"),
    ).reset_index()
    return numbers.assign(
        share=numbers["possible"] / numbers["candidates"],
        found=numbers["found"] / numbers["repeats"],
    ).drop(columns=["repeats", "candidates", "possible"])


def curves(
    settings: SizeEffectParameters, files: Mapping[str, Path], units: str | None, worker_count: int
) -> tuple[pd.DataFrame, dict[str, str]]:
    """Grasp quality over size (`SIZE_EFFECT`) of repaired mesh files; reasons of rejected ones."""
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
