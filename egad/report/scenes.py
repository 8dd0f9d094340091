"""Objects of a dataset with their labelled grasps, for the viewer."""

from pathlib import Path

import pandas as pd
import pyarrow as pa

from egad.io import read_mesh
from egad.report.viewer import GraspScene
from egad.tables import parquet
from egad.tables.columns import ID, LABEL
from egad.tables.objects import REJECTED


def scenes(
    folder: Path, gripper: str, evalset: pd.DataFrame, grasps: pd.DataFrame
) -> list[GraspScene]:
    """The objects of an evaluation set that could be scaled to the gripper, named as in the set."""
    meshes = folder / "rescaled" / gripper
    return [
        scene(folder, gripper, label, grasps, name=name)
        for name, label in zip(evalset["label"], evalset["object_label"], strict=True)
        if (meshes / f"{label}.obj").is_file()
    ]


def scene(
    folder: Path, gripper: str, label: str, grasps: pd.DataFrame, name: str | None = None
) -> GraspScene:
    """An object of a dataset, by its label or another name; a note says why it has no grasps."""
    mesh = read_mesh(folder / "rescaled" / gripper / f"{label}.obj", "m")
    own = grasps[grasps["label"] == label]
    note = "" if len(own) else _reason(folder, gripper, label)
    return GraspScene(name or label, label if name else "", mesh, own, note)


def _reason(folder: Path, gripper: str, label: str) -> str:
    """Why an object has no grasp, from the table of rejected objects."""
    objects = parquet.read(folder / "objects.parquet", pa.schema([ID, LABEL]))
    rejected = parquet.read(folder / "grasps" / f"{gripper}.rejected.parquet", REJECTED)
    own = rejected[rejected["id"].isin(objects.loc[objects["label"] == label, "id"])]
    return own["reason"].iloc[0] if len(own) else "no grasp"
