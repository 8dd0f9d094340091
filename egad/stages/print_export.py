"""print-export: STL files and 3MF plates of the evaluation set, in millimetres."""

import logging
from pathlib import Path

import numpy as np
import pandas as pd

from egad.evalset.printing import PrintItem, plan_prints
from egad.exchange.meshes import read_mesh, write_stl_mm
from egad.exchange.threemf import Placed, write_3mf
from egad.files import replacing
from egad.stage_settings import PrintFiles
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, MANIFEST
from egad.tables.grasping import SCALES

log = logging.getLogger(__name__)


def run(settings: PrintFiles, evaluation: Path, meshes: Path, scales: Path, out: Path) -> None:
    """Write everything that a printer needs.

    Args:
        settings: Bed and gap.
        evaluation: Table with the columns of `tables.evaluation.EVAL49`.
        meshes: Folder of the meshes, scaled to the gripper.
        scales: Table with the columns of `tables.grasping.SCALES`.
        out: Folder for `LABEL.stl`, `plate-N.3mf` and `manifest.parquet`.
    """
    chosen = parquet.records(parquet.read(evaluation, EVAL49))
    factors = parquet.read(scales, SCALES).set_index("label")["factor"]
    solids = {row["label"]: read_mesh(meshes / f"{row['object_label']}.obj", "m") for row in chosen}
    items = plan_prints(solids, settings.print_export.bed, settings.print_export.gap)
    rows = [
        _manifest_row(row["label"], row["id"], items[row["label"]], factors[row["object_label"]])
        for row in chosen
    ]
    with replacing(out) as folder:
        folder.mkdir()
        for label, item in items.items():
            write_stl_mm(item.mesh, folder / f"{label}.stl")
        for plate in sorted({item.plate for item in items.values() if item.plate is not None}):
            _write_plate(plate, items, folder / f"plate-{plate}.3mf")
        parquet.write(pd.DataFrame(rows), MANIFEST, folder / "manifest.parquet")
    log.info("%d objects", len(items))


def _write_plate(plate: int, items: dict[str, PrintItem], path: Path) -> None:
    placed = {
        label: Placed(item.mesh, np.array([*item.place, 0.0]))
        for label, item in items.items()
        if item.plate == plate and item.place is not None
    }
    write_3mf(placed, path, {"Title": f"EGAD evaluation set, plate {plate}"})


def _manifest_row(label: str, object_id: str, item: PrintItem, factor: float) -> dict[str, object]:
    x, y = item.place or (np.nan, np.nan)
    return {
        "label": label,
        "id": object_id,
        "file": f"{label}.stl",
        "plate": item.plate,
        "place_x": 1e3 * x,
        "place_y": 1e3 * y,
        **dict(zip(("extents_x", "extents_y", "extents_z"), 1e3 * item.mesh.extents, strict=True)),
        "volume": 1e9 * item.mesh.volume,
        "factor": factor,
        "note": item.note,
    }
