"""Rows of the objects of a dataset: repaired, measured, and with cells and labels."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray

from egad._util.progress import progress
from egad.errors import RejectedError
from egad.geometry import MassProperties, mass_properties
from egad.geometry.repair import Repaired, repair_for_files
from egad.measures.grid import complexity_cells, difficulty_cells, labels
from egad.measures.measure import measure_repeatably
from egad.measures.parameters import CellsAndDiversities, MeasureMeshes
from egad.measures.reeb import diversities
from egad.measures.reeb import graph as reeb
from egad.tables.columns import inertia_columns

MIN_VOLUME = 1e-9  # m3: objects with a smaller volume are rejected


def repaired_body(
    mesh: trimesh.Trimesh, settings: MeasureMeshes
) -> tuple[Repaired, MassProperties]:
    """Repair a mesh, and compute its mass properties; `RejectedError` if it is too small."""
    rules = settings.postprocess
    repaired = repair_for_files(mesh, rules.open_surfaces, rules.shell_thickness)
    mass = mass_properties(repaired.mesh, settings.material.density)
    if mass.volume < MIN_VOLUME:
        raise RejectedError(
            f"volume of {mass.volume:.3g} m3 is below {MIN_VOLUME:.3g} m3: "
            "is the unit of the mesh right?"
        )
    return repaired, mass


def solid_row(
    mesh: trimesh.Trimesh, object_id: str, settings: MeasureMeshes, *, resample: bool = True
) -> dict[str, Any]:
    """The row of `tables.objects.SOLIDS` of one object, or `RejectedError`."""
    repaired, mass = repaired_body(mesh, settings)
    solid = repaired.mesh
    most = settings.postprocess.max_candidates
    place = measure_repeatably(solid, settings, most, resample=resample)
    return {
        "id": object_id,
        **place._asdict(),
        "volume": mass.volume,
        "area": mass.area,
        "watertight": bool(solid.is_watertight),
        "repaired": repaired.changed,
        "shell_thickness": repaired.shell_thickness,
        "dropped_bodies": repaired.dropped_bodies,
        "dropped_volume": repaired.dropped_volume,
        **dict(zip(("extents_x", "extents_y", "extents_z"), solid.extents, strict=True)),
        **dict(zip(("com_x", "com_y", "com_z"), mass.com, strict=True)),
        "mass": mass.mass,
        **inertia_columns(mass.inertia),
        "vertices": solid.vertices.ravel(),
        "faces": solid.faces.ravel(),
        "graph": reeb.pack(reeb.extract(solid, settings.similarity)),
    }


def arrange(
    frame: pd.DataFrame, settings: CellsAndDiversities, evolved: bool, threads: int = 1
) -> pd.DataFrame:
    """Add cells, diversities and labels; sort by label."""

    def shown(batches: list[NDArray[np.int64]]) -> Iterator[NDArray[np.int64]]:
        return progress(batches, "comparing objects, batches", len(batches))

    graphs = [reeb.unpack(data) for data in frame["graph"]]
    space = settings.space
    frame = frame.assign(
        complexity_cell=complexity_cells(frame["complexity"], space),
        difficulty_cell=difficulty_cells(frame["graspability"], space),
        diversity=diversities(graphs, settings.similarity.weight, space.neighbors, threads, shown),
    )
    if not evolved:
        return frame.assign(label=frame["id"]).sort_values("label", ignore_index=True)
    frame = frame.sort_values(
        ["difficulty_cell", "complexity_cell", "diversity", "id"],
        ascending=[True, True, False, True],
        ignore_index=True,
    )
    return frame.assign(label=labels(frame["complexity_cell"], frame["difficulty_cell"]))
