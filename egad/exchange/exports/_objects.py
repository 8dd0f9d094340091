"""Objects in the formats of `egad.exchange`: the evaluation set, or all objects."""

import logging
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from egad._util.files import atomic_output, check_empty
from egad._util.progress import progress
from egad.exchange import (
    MESH_WRITERS,
    PHYSICS_WRITERS,
    check_installed,
    read_convex_objects,
    read_mesh,
    read_simulation_object,
)
from egad.exchange.parameters import AllObjects, GripperFormat
from egad.tables import parquet
from egad.tables.evaluation import BUNDLE

log = logging.getLogger(__name__)


def run_evaluation_set(
    settings: GripperFormat,
    style: str,
    gripper: str,
    bundle: Path,
    out: Path,
) -> None:
    """Write the objects of a simulation bundle.

    Args:
        settings: Settings of this format.
        style: The format.
        gripper: Name of the gripper.
        bundle: Folder of the bundle.
        out: Objects scaled to gripper G, if `targets.exports` names a format of objects, OBJECTS:
            `usd`, `sdf`, `urdf`, `mjcf`, `robosuite`, `vgn`, `simulation`, `glb`, `obj` or `stl`.
            They are the evaluation set, or all if `targets.export_objects` says so. See
            `docs/exchange.md`.

    Raises:
        UserError: A file of the bundle is missing or damaged, the format needs a package that is
            not installed, or the folder is not empty.
    """
    del settings, gripper
    rows = parquet.records(parquet.read(bundle / "bundle.parquet", BUNDLE))
    with _objects_folder(out, style) as folder:
        for row in progress(rows, "writing objects", len(rows)):
            made = read_simulation_object(bundle, row)
            if style in MESH_WRITERS:
                MESH_WRITERS[style](folder, row["label"], made.mesh)
            else:
                PHYSICS_WRITERS[style](folder, row["label"], made, row["friction"])
    log.info("%d objects", len(rows))


def run_all(
    settings: AllObjects,
    style: str,
    gripper: str,
    meshes: Path,
    convex_parts: Path | None,
    out: Path,
) -> None:
    """Write all objects of a dataset.

    Args:
        settings: Settings of this format.
        style: The format.
        gripper: Name of the gripper.
        meshes: Folder of the scaled meshes.
        convex_parts: Table with the columns of `tables.evaluation.CONVEX_PARTS`, sorted by label;
            none for formats of surfaces.
        out: As in `run_evaluation_set`.

    Raises:
        UserError: The format needs a package that is not installed, or the folder is not empty.
        TableError: The table is damaged.
    """
    del gripper
    paths = {path.stem: path for path in sorted(meshes.glob("*.obj"))}
    with _objects_folder(out, style) as folder:
        if convex_parts is None:
            for label, path in progress(paths.items(), "writing objects", len(paths)):
                MESH_WRITERS[style](folder, label, read_mesh(path, "m"))
            return
        found = read_convex_objects(convex_parts, meshes, settings.material.density)
        written = set()
        for label, made in progress(found, "writing objects", len(paths)):
            PHYSICS_WRITERS[style](folder, label, made, settings.bundle.friction)
            written.add(label)
    _warn_of(paths.keys() - written, convex_parts)
    log.info("%d objects", len(written))


@contextmanager
def _objects_folder(out: Path, style: str) -> Iterator[Path]:
    check_installed(style)
    check_empty(out)
    with atomic_output(out, keep=False) as folder:
        folder.mkdir()
        yield folder


def _warn_of(labels: Iterable[str], convex_parts: Path) -> None:
    for label in sorted(labels):
        log.warning("%s is left out: it has no convex parts in %s", label, convex_parts)
