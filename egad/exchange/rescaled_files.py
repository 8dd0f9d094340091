"""rescale: meshes scaled to a gripper."""

import logging
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import trimesh

from egad._util.arrays import Floats
from egad._util.files import atomic_output
from egad._util.progress import progress
from egad._util.workers import workers
from egad.exchange.parameters import RescaleMeshes
from egad.geometry import RayCaster, rescale, spread
from egad.io import object_names, use_mesh, warn_of_units, write_mesh
from egad.tables import parquet
from egad.tables.grasping import SCALES
from egad.tables.objects import REJECTED, rejection

log = logging.getLogger(__name__)
BOTH = ("before", "after")
SPACING = 0.05  # of the longest side of the mesh: largest distance between points
SKIN = 1e-6  # of it: how far below the surface rays start


def rescale_files(
    settings: RescaleMeshes,
    meshes: list[Path],
    units: str | None,
    out: Path,
    ending: str = "obj",
    suffix: str = "",
    jobs: int = 1,
) -> int:
    """Scale every mesh by the rule into `out`; return how many files could not be used."""
    named = object_names(meshes)
    scales, left_out, sides = [], [], {}
    with workers(jobs) as mapper, atomic_output(out) as folder:
        folder.mkdir()
        work = partial(
            _scaled, units=units, settings=settings, folder=folder, tail=f"{suffix}.{ending}"
        )
        results = mapper(work, named.items())
        done = progress(results, "scaling", len(named))
        for name, (result, sides[name]) in zip(named, done, strict=True):
            if isinstance(result, str):
                left_out.append(rejection(name, "rescale", result))
            else:
                scales.append({"label": name, **result})
        parquet.write(pd.DataFrame(scales), SCALES, folder / "scales.parquet")
        parquet.write(pd.DataFrame(left_out), REJECTED, folder / "rejected.parquet")
    warn_of_units(sides, units)
    rule = settings.rescale.rule
    log.info("%d meshes scaled by rule %s, %d rejected", len(scales), rule, len(left_out))
    if scales and settings.gripper.kind.closes:
        _log_fit(scales, settings.gripper.opening)
    return len(left_out)


def _log_fit(scales: list[dict[str, Any]], opening: float) -> None:
    before, after = (
        100 * np.mean([row[f"graspable_fraction_{when}"] for row in scales]) for when in BOTH
    )
    text = "%.0f %% of their surface fits into an opening of %g mm, before scaling %.0f %%"
    log.info(text, after, 1000 * opening, before)


def _scaled(
    named: tuple[str, Path], units: str | None, settings: RescaleMeshes, folder: Path, tail: str
) -> tuple[dict[str, Any] | str, float]:
    """Write a scaled mesh; return its row, or why there is none, and its longest side."""
    (name, path), rule, opening = named, settings.rescale, settings.gripper.opening
    result, longest = use_mesh(
        path, units, lambda mesh: (mesh, *rescale(mesh, rule.rule, opening, rule.side_fraction))
    )
    if isinstance(result, str):
        return result, longest
    mesh, scaled, row = result
    widths, areas = graspable_widths(mesh)
    file = folder / f"{name}{tail}"
    write_mesh(scaled, file)
    row |= {
        "graspable_fraction_before": graspable_fraction(widths, areas, opening),
        "graspable_fraction_after": graspable_fraction(row["factor"] * widths, areas, opening),
        "file": file.name,
    }
    return row, longest


def graspable_widths(mesh: trimesh.Trimesh) -> tuple[Floats, Floats]:
    """Thickness of a closed mesh behind points, (n,), and the area that each represents, (n,)."""
    size = float(np.max(mesh.extents))
    samples = spread(mesh, SPACING * size)
    starts = samples.points - SKIN * size * samples.normals
    hits = RayCaster(mesh).first_hits(starts, -samples.normals)
    shares = np.bincount(samples.faces, minlength=len(mesh.faces))
    return hits.distances + SKIN * size, (mesh.area_faces / np.maximum(shares, 1))[samples.faces]


def graspable_fraction(widths: Floats, areas: Floats, opening: float) -> float:
    """Fraction of the surface, by area, whose widths are at most the opening."""
    return float(areas[widths <= opening].sum() / areas.sum())
