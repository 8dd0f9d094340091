"""Simulation bundles: objects, each a folder with meshes, URDF, MJCF and its poses at rest."""

import logging
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import trimesh

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad._util.workers import workers
from egad.exchange.objects.simulation import write_simulation_object
from egad.exchange.simulation_page import page
from egad.io import object_names, use_mesh, warn_of_units, write_sums
from egad.sim import SimulationBundle, SimulationObject, make_simulation_object
from egad.tables import parquet
from egad.tables.columns import inertia_columns
from egad.tables.evaluation import BUNDLE, EVAL49
from egad.tables.objects import REJECTED, rejection

log = logging.getLogger(__name__)


class Item(NamedTuple):
    """A mesh file, and what the object in it is called."""

    label: str
    id: str
    path: Path


def evaluation_objects(evaluation: Path, meshes: Path) -> list[Item]:
    """The objects of a table with the columns of `tables.evaluation.EVAL49`."""
    chosen = parquet.records(parquet.read(evaluation, EVAL49))
    return [Item(row["label"], row["id"], meshes / f"{row['object_label']}.obj") for row in chosen]


def any_objects(files: list[Path]) -> list[Item]:
    """Mesh files as objects: label and id are their names."""
    return [Item(name, name, path) for name, path in object_names(files).items()]


def write_bundle(
    settings: SimulationBundle,
    objects: list[Item],
    units: str | None,
    out: Path,
    worker_count: int = 1,
) -> int:
    """Write all files that a simulator needs into `out`; return how many objects were left out."""
    rows, left_out, sides = [], [], {}
    with workers(worker_count) as mapper, atomic_output(out) as folder:
        folder.mkdir()
        results = mapper(partial(_made, units=units, settings=settings), objects)
        done = progress(results, "making", len(objects))
        for item, (made, sides[item.label]) in zip(objects, done, strict=True):
            if isinstance(made, str):
                left_out.append(rejection(item.id, "bundle", f"{item.label}: {made}"))
            else:
                friction = settings.bundle.friction
                write_simulation_object(folder / item.label, item.label, made, friction)
                rows.append(_row(item, made, settings))
        table = pd.DataFrame(rows, columns=BUNDLE.names)
        parquet.write(table, BUNDLE, folder / "bundle.parquet")
        parquet.write(pd.DataFrame(left_out), REJECTED, folder / "rejected.parquet")
        (folder / "README.md").write_text(
            page(table, left_out, settings.material.density, settings.bundle), encoding="utf-8"
        )
        write_sums(folder)
    warn_of_units(sides, units)
    log.info("%d objects, %d rejected", len(rows), len(left_out))
    return len(left_out)


def _made(
    item: Item, units: str | None, settings: SimulationBundle
) -> tuple[SimulationObject | str, float]:
    """An object ready for simulators, or the reason why there is none; and its longest side."""

    def make(mesh: trimesh.Trimesh) -> SimulationObject:
        made = make_simulation_object(mesh, settings.material.density, settings.bundle, item.label)
        _ = made.poses  # slow for round objects: not computed where all objects are written
        return made

    return use_mesh(item.path, units, make)


def _row(item: Item, made: SimulationObject, settings: SimulationBundle) -> dict[str, Any]:
    physics = made.physics
    return {
        "label": item.label,
        "id": item.id,
        "method": settings.bundle.method,
        "parts": len(made.parts),
        "volume_error": made.volume_error,
        "deviation": made.deviation,
        "buried": made.buried,
        "deviation_bound": made.deviation_bound,
        "within": made.within,
        "poses": len(made.poses),
        "volume": physics.volume,
        "density": settings.material.density,
        "friction": settings.bundle.friction,
        "mass": physics.mass,
        **dict(zip(("com_x", "com_y", "com_z"), physics.com, strict=True)),
        **inertia_columns(physics.inertia),
    }
