"""Labelled grasps, read for people and for other formats."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.errors import UserError
from egad.grasps.poses import hand_poses
from egad.tables import parquet
from egad.tables.grasping import GRASPS, SCALES

Floats = NDArray[np.float64]


def load_grasps(path: str | Path, gripper: str | None = None) -> tuple[pd.DataFrame, Floats]:
    """The labelled grasps of a dataset, and the poses of the hand.

    Args:
        path: Folder of a dataset, e.g. `results/egad`, or a table of grasps.
        gripper: Name of the gripper; only with a folder.

    Returns:
        A row a grasp, as `results/README.md` says, and (n, 4, 4) poses in the same order. A pose
        maps from the frame of the hand to that of the object: its origin is midway between the
        contacts, x closes (from the first contact to the second), z approaches. Metres.

    Raises:
        UserError: There is no such gripper in the folder, none is named, or one with a file.
        TableError: The table is damaged, or is not one of grasps.
    """
    frame = parquet.read(grasp_table(Path(path), gripper), GRASPS)
    return frame, poses_of(frame)


def grasp_table(path: Path, gripper: str | None) -> Path:
    """The table of grasps: the file itself, or that of a gripper in the folder of a dataset."""
    if path.is_file():
        if gripper is not None:
            raise UserError(f"{path}: a gripper is named with the folder of a dataset, not a file")
        return path
    known = sorted(
        file.stem for file in (path / "grasps").glob("*.parquet") if "." not in file.stem
    )
    if not known:
        raise UserError(f"{path}: neither a table of grasps nor a dataset that has any")
    if gripper not in known:
        asked = "name a gripper" if gripper is None else f"no grasps of gripper {gripper!r}"
        raise UserError(f"{path}: {asked}; there are {', '.join(known)}")
    return path / "grasps" / f"{gripper}.parquet"


def check_opening(dataset: Path, gripper: str, opening: float) -> None:
    """Make sure that a gripper is the one that the objects of a dataset were scaled to.

    Args:
        dataset: Its folder.
        gripper: The gripper's name.
        opening: Its opening, metres, as the settings have it.

    Raises:
        UserError: Its opening was another one.
        TableError: The table of scales is missing or damaged.
    """
    path = dataset / "rescaled" / gripper / "scales.parquet"
    for other in parquet.read(path, SCALES)["opening"].unique():
        if not np.isclose(other, opening, rtol=1e-9, atol=0):
            raise UserError(
                f"gripper {gripper!r} opens {opening:g} m in the settings, but {other:g} m in "
                f"{path}; give the configuration of that run with --config"
            )


def poses_of(frame: pd.DataFrame) -> Floats:
    """Poses of the hand, (n, 4, 4), of rows with the columns `center`, `axis` and `approach`."""
    return hand_poses(*(vectors(frame, name) for name in ("center", "axis", "approach")))


def vectors(frame: pd.DataFrame, name: str) -> Floats:
    """The columns `NAME_x`, `NAME_y`, `NAME_z` as (n, 3)."""
    return np.asarray(frame[[f"{name}_{part}" for part in "xyz"]], dtype=np.float64).reshape(-1, 3)


def by_object(path: Path, columns: list[str]) -> Iterator[tuple[str, pd.DataFrame]]:
    """The grasps of one object after the other, never more than some thousands in memory.

    Args:
        path: A table of grasps, sorted by label.
        columns: Columns to read besides `label`.

    Yields:
        Labels, ascending, and the rows of each object in their order.

    Raises:
        UserError: The table is not sorted by label.
        TableError: It is damaged, or lacks columns.
    """
    rest, last = pd.DataFrame(), ""
    for batch in parquet.batches(path, ["label", *columns]):
        rows = pd.concat([rest, batch]) if len(rest) else batch
        groups = [(str(label), group) for label, group in rows.groupby("label", sort=False)]
        rest = groups[-1][1]
        for label, group in groups[:-1]:
            last = _ascending(path, last, label)
            yield label, group
    if len(rest):
        label = str(rest["label"].iloc[0])
        _ascending(path, last, label)
        yield label, rest


def _ascending(path: Path, last: str, label: str) -> str:
    if label <= last:
        raise UserError(f"{path}: its rows must be sorted by label, but {last} is before {label}")
    return label
