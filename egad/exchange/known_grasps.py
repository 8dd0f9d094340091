"""Known grasps as a detector: `grasps:FILE`, or `grasps:FOLDER` with a file for each object."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
import trimesh

from egad.bench.preparation import Lazy, grasps_by_id
from egad.detectors import DetectorConfig
from egad.errors import UserError
from egad.exchange.bundled import rows_by_id
from egad.exchange.grasp_files import LOADERS
from egad.exchange.objects.simulation import read_simulation_object
from egad.exchange.reading import read_grasps
from egad.grasps import Grasps
from egad.grippers import GRIPPERS, Gripper
from egad.io import object_names
from egad.objects import NamedMesh, scaled_solid
from egad.tables import parquet
from egad.tables.grasping import GRASPS


def files_of_grasps(path: Path) -> list[Path]:
    """The file, or all files of grasps in the folder; UserError if there is none."""
    inside = [path] if path.is_file() else sorted(path.glob("*"))
    files = [each for each in inside if path.is_file() or each.suffix.lower() in LOADERS]
    if not files:
        endings = ", ".join(LOADERS)
        raise UserError(f"{path} is neither a file of grasps nor a folder of them ({endings})")
    return files


def known_grasps(
    path: Path, targets: Sequence[NamedMesh], gripper: Gripper, rule: str
) -> tuple[Mapping[str, pd.DataFrame], list[Path]]:
    """Grasps for `labels` by id, each read when it is looked up, and their files; or UserError.

    A file is that of the only object. Files in a folder are named after the objects.
    """
    files = object_names(files_of_grasps(path))
    if path.is_file():
        files = {each.label: path for each in targets[:1]}
    hand = next((name for name, each in GRIPPERS.items() if each == gripper), gripper)

    by_label = {each.label: each for each in targets}

    def read(label: str) -> Grasps:
        solid = scaled_solid(by_label[label], gripper, rule)
        try:
            return read_grasps(files[label], None, solid, hand)
        except UserError as error:
            fix = "`egad grasps check FILE --fix FIXED.npz` takes what a file leaves open, and"
            raise UserError(f"{error}; {fix} writes a file that says so") from error

    tables = grasps_by_id(Lazy({label: partial(read, label) for label in files}), targets)
    return tables, [files[label] for label in by_label]


def labels_in_bundle(
    detector: DetectorConfig, gripper: Gripper, bundle: Path, table: Path | None
) -> Mapping[str, pd.DataFrame]:
    """Grasps by id of objects of a bundle: the known ones of a detector, or those of a table."""
    if detector.known_grasps:

        def mesh(row: Mapping[str, Any]) -> trimesh.Trimesh:
            return read_simulation_object(bundle, row).mesh

        rows = rows_by_id(bundle).items()
        targets = [NamedMesh(row["label"], name, partial(mesh, row)) for name, row in rows]
        return known_grasps(detector.known_grasps, targets, gripper, "none")[0]
    if table is None:
        raise UserError("the detector `labels` needs the table of labelled grasps")
    return {str(name): rows for name, rows in parquet.read(table, GRASPS).groupby("id")}
