"""Files of the evaluation set for 3D printers: STL files and 3MF plates, in millimetres."""

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
from egad.errors import RejectedError
from egad.evalset.engraving import engrave
from egad.evalset.filament import print_settings
from egad.evalset.parameters import PrintExport, PrintFiles
from egad.evalset.plate_files import PlacedMesh, write_3mf
from egad.evalset.plates import PrintItem, plan_prints
from egad.evalset.print_poses import OVERHANG_ANGLE
from egad.evalset.printability import print_problems
from egad.geometry import scale_suffix
from egad.io import read_mesh, write_stl_mm
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, MANIFEST
from egad.tables.grasping import SCALES

log = logging.getLogger(__name__)
Row = dict[str, Any]


def write_print_files(
    settings: PrintFiles,
    gripper: str,
    evaluation: Path,
    meshes: Path,
    scales: Path,
    out: Path,
    grasps: Path | None = None,
) -> None:
    """Write STL and 3MF files of the evaluation set, in millimetres, named objects on plates.

    An object without a mesh, too thin, or too large for the bed gets a note in the table instead of
    files. The table of the scales is in the folder of the scaled meshes. Engraved labels avoid the
    contacts of the grasps.
    """
    chosen = parquet.records(parquet.read(evaluation, EVAL49))
    solids, missing = _read(chosen, meshes)
    wanted = settings.print_export
    engraved = _engraved(solids, chosen, grasps, settings) if wanted.engraving else {}
    watch = partial(progress, what="laying objects down", total=len(solids))
    items = plan_prints(solids | engraved, wanted, settings.print_check, watch)
    factors = parquet.read(scales, SCALES).set_index("label")["factor"].to_dict()
    rows = []
    for row in chosen:
        label, factor = row["label"], factors.get(row["object_label"], np.nan)
        found = {"note": missing.get(label, "")}
        if label in items:
            found = _printed(label, items[label], label in engraved, settings)
        rows.append(_base_row(row, factor, wanted) | found)
    with atomic_output(out) as folder:
        folder.mkdir()
        _write(folder, items, rows, gripper, settings)
    _log_result(rows, gripper, settings)


def _write(
    folder: Path, items: dict[str, PrintItem], rows: list[Row], gripper: str, settings: PrintFiles
) -> None:
    for label, item in progress(items.items(), "writing files", len(items)):
        write_stl_mm(item.pose.mesh, folder / _file(label, settings))
    for plate in sorted({item.plate for item in items.values() if item.plate is not None}):
        told = {row["label"]: row["factor"] for row in rows if row["plate"] == plate}
        _write_plate(plate, items, folder / f"plate-{plate}.3mf", told, gripper, settings)
    parquet.write(pd.DataFrame(rows), MANIFEST, folder / "manifest.parquet")


def _read(chosen: list[Row], meshes: Path) -> tuple[dict[str, trimesh.Trimesh], dict[str, str]]:
    """The meshes by label, and the reason for each one that is missing."""
    solids, missing = {}, {}
    for row in chosen:
        try:
            solids[row["label"]] = read_mesh(meshes / f"{row['object_label']}.obj", "m")
        except RejectedError as reason:
            missing[row["label"]] = f"no mesh {row['object_label']}.obj: {reason}"
    return solids, missing


def _engraved(
    solids: dict[str, trimesh.Trimesh], chosen: list[Row], grasps: Path | None, settings: PrintFiles
) -> dict[str, trimesh.Trimesh]:
    """Copies with engraved labels, of the objects that can be printed with them."""
    names = {row["label"]: row["object_label"] for row in chosen}
    touched = _contacts(grasps, set(names.values())) if grasps else {}
    cut = {
        label: engrave(
            mesh, label, settings.print_check.wall, touched.get(names[label], np.empty((0, 3)))
        )
        for label, mesh in progress(solids.items(), "engraving", len(solids))
    }
    return {
        label: mesh
        for label, mesh in cut.items()
        if mesh is not None and not print_problems(mesh, settings.print_check)
    }


def _contacts(path: Path, wanted: set[str]) -> dict[str, Floats]:
    """Contacts of the grasps that the hand can use, (n, 3), by name of the object."""
    ends = [f"contact{end}_{axis}" for end in "01" for axis in "xyz"]
    found: dict[str, list[Floats]] = {}
    for batch in parquet.batches(path, ["label", "collision_free", *ends]):
        usable = batch[batch["collision_free"] & batch["label"].isin(wanted)]
        for label, rows in usable.groupby("label"):
            found.setdefault(str(label), []).append(rows[ends].to_numpy().reshape(-1, 3))
    return {label: np.concatenate(parts) for label, parts in found.items()}


def _write_plate(
    plate: int,
    items: dict[str, PrintItem],
    path: Path,
    factors: dict[str, float],
    gripper: str,
    settings: PrintFiles,
) -> None:
    placed = {
        label: PlacedMesh(item.pose.mesh, np.array([*item.place, 0.0]))
        for label, item in items.items()
        if item.plate == plate and item.place is not None
    }
    opening = f"{1000 * settings.gripper.opening:g} mm"
    scales = ", ".join(f"{label} {factor:.4f}" for label, factor in factors.items())
    metadata = {
        "Title": f"EGAD evaluation set, plate {plate}, gripper {gripper}",
        "Application": "egad",
        "Description": f"Scaled for gripper {gripper} (opening {opening}) by rule "
        f"{settings.rescale.rule}. Scale of each object: {scales}. "
        f"Print with {_advice(settings.print_export)}.",
    }
    write_3mf(placed, path, metadata)


def _advice(settings: PrintExport) -> str:
    return (
        f"{print_settings(settings)}, supports beyond {OVERHANG_ANGLE:g} degrees from the vertical"
    )


def _base_row(row: Row, factor: float, settings: PrintExport) -> Row:
    """The row of an object without print files."""
    numbers = [field.name for field in MANIFEST if str(field.type) == "double"]
    return {
        **dict.fromkeys(numbers, np.nan),
        "label": row["label"],
        "id": row["id"],
        "file": "",
        "plate": None,
        "pose": settings.pose,
        "factor": factor,
        "settings": _advice(settings),
        "engraved": False,
        "note": "",
    }


def _printed(label: str, item: PrintItem, engraved: bool, settings: PrintFiles) -> Row:
    """What is known of an object as it will be printed."""
    x, y = item.place or (np.nan, np.nan)
    mesh = item.pose.mesh
    plain = settings.print_export.engraving and not engraved and item.plate is not None
    notes = [item.note, "no space for its label" if plain else ""]
    return {
        "file": _file(label, settings),
        "plate": item.plate,
        "place_x": 1e3 * x,
        "place_y": 1e3 * y,
        **dict(zip(("extents_x", "extents_y", "extents_z"), 1e3 * mesh.extents, strict=True)),
        "volume": 1e9 * mesh.volume,
        "filament": 1e3 * item.filament,
        "pose_probability": item.pose.probability,
        "overhang": 1e6 * item.pose.overhang,
        "contact": 1e6 * item.pose.contact,
        "engraved": engraved,
        "note": "; ".join(filter(None, notes)),
    }


def _file(label: str, settings: PrintFiles) -> str:
    return f"{label}{scale_suffix(settings.rescale.rule, settings.gripper.opening)}.stl"


def _log_result(rows: list[Row], gripper: str, settings: PrintFiles) -> None:
    plates = {row["plate"] for row in rows} - {None}
    log.info("%d objects, %d plates", len(rows), len(plates))
    if plates and not settings.print_export.engraving:
        log.info(
            "The prints do not carry their labels; print_export: {engraving: true} cuts them in"
        )
    for row in rows:
        if row["plate"] is None:
            log.info("%s is on no plate: %s", row["label"], row["note"])
    if rows and not plates:
        log.warning(
            "No object can be printed for gripper %s with its opening of %g mm: "
            "use a wider gripper, a finer nozzle (print_check.wall) or a larger bed",
            gripper,
            1000 * settings.gripper.opening,
        )
