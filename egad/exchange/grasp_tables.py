"""Labelled grasps, read for people and for other formats."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from egad._util.files import as_path
from egad._util.progress import progress
from egad.errors import UserError
from egad.grasps import Grasps
from egad.tables import parquet
from egad.tables.grasping import GRASPS, SCALES, SIMULATED_GRASPS

QUALITIES = (
    "quality",
    "robust_quality",
    "robust_quality_std",
    "robust_success_rate",
    "fits",
    "collision_free",
    "needed_opening",
)
SIMULATED_COLUMNS = [name for name in SIMULATED_GRASPS.names if name not in ("id", "label")]


def load_grasps(path: str | Path, gripper: str | None = None) -> Grasps:
    """The labelled grasps of a dataset.

    Args:
        path: Folder of a dataset, e.g. `results/egad`, or a table of grasps.
        gripper: Name of the gripper; only with a folder.

    Returns:
        The grasps of all objects, each in the frame of its object, scaled to the gripper;
        `of(label)` gives those of one object. `to_frame()` has their simulated labels, too, if they
        were simulated.

    Raises:
        UserError: There is no such gripper in the folder, or none is named; a gripper is named for
            a file; or `path` is not a path.
        TableError: The table is damaged, or is not one of grasps.
    """
    table = grasp_table(as_path("path", path), gripper)
    return Grasps(parquet.read(table, SIMULATED_GRASPS if is_simulated(table) else GRASPS))


def is_simulated(grasps: Path) -> bool:
    """Whether a table of grasps has simulated labels."""
    return "simulated_outcome" in parquet.columns(grasps)


def grasp_table(path: Path, gripper: str | None) -> Path:
    """The table of grasps: the file itself, or that of a gripper in the folder of a dataset."""
    if path.is_file():
        if gripper is not None:
            raise UserError(
                f"{path}: a gripper can be given only for the folder of a dataset, not for a file"
            )
        return path
    known = sorted(
        file.stem for file in (path / "grasps").glob("*.parquet") if "." not in file.stem
    )
    if not known:
        raise UserError(f"{path}: neither a table of grasps nor a dataset with grasps")
    if gripper not in known:
        asked = "name a gripper" if gripper is None else f"no grasps for gripper {gripper!r}"
        raise UserError(f"{path}: {asked}; available: {', '.join(known)}")
    return path / "grasps" / f"{gripper}.parquet"


def check_opening(dataset: Path, gripper: str, opening: float) -> None:
    """Raise UserError if the objects of a dataset were scaled to another opening, metres."""
    path = dataset / "rescaled" / gripper / "scales.parquet"
    for other in parquet.read(path, SCALES)["opening"].unique():
        if not np.isclose(other, opening, rtol=1e-9, atol=0):
            raise UserError(
                f"gripper {gripper!r} opens {opening:g} m in the settings, but {other:g} m in "
                f"{path}; give the configuration of that run with --config"
            )


def by_object(path: Path, columns: list[str]) -> Iterator[tuple[str, pd.DataFrame]]:
    """Rows of one label after the other, few at a time; UserError if not sorted by label."""
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


def check_simulated(grasps: Path) -> None:
    """Raise UserError, which says how to get them, if grasps have no simulated labels."""
    if not is_simulated(grasps):
        raise UserError(
            f"{grasps} has no simulated labels, which this format needs: they say whether a grasp "
            "succeeded. Run the workflow with targets: {simulated_labels: true}"
        )


def simulated_by_object(grasps: Path) -> Iterator[tuple[str, pd.DataFrame]]:
    """The grasps of one object after the other: see `check_simulated` and `by_object`."""
    check_simulated(grasps)
    labels = parquet.distinct(grasps, "label")
    return progress(by_object(grasps, SIMULATED_COLUMNS), "writing grasps", len(labels))
