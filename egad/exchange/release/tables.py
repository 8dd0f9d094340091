"""The rows of a dataset release, from the tables of a run (ours)."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from egad.grasps import Grasps
from egad.tables import parquet
from egad.tables.grasping import SIMULATED_GRASPS
from egad.tables.release import MAX_FILES, RELEASED_GRASPS

ROWS = 50_000  # in a file of grasps, at most: about 10 MB


def file_stems(names: Iterable[str]) -> dict[str, str]:
    """The file of each object in a folder, without ending: `NAME`, or `NN/NAME` if too many."""
    listed = list(names)
    cut = len(listed) > MAX_FILES
    folders = [f"{number // MAX_FILES:02d}/" * cut for number in range(len(listed))]
    return {name: folder + name for folder, name in zip(folders, listed, strict=True)}


def with_files(table: pd.DataFrame, labels: Iterable[str]) -> pd.DataFrame:
    """A table with the columns `mesh` and `preview`: files of the objects with these labels."""
    stems = file_stems(labels).values()
    return table.assign(
        mesh=[f"meshes/{stem}.glb" for stem in stems],
        preview=[f"previews/{stem}.png" for stem in stems],
    )


def released_objects(
    objects: pd.DataFrame,
    scales: pd.DataFrame,
    simulated: pd.DataFrame,
    counts: Mapping[str, int],
    evaluation: Iterable[str],
) -> pd.DataFrame:
    """Columns of `RELEASED_OBJECTS` without split, family and gripper, by label."""
    factors = scales.set_index("label")[["opening", "factor"]]
    labels = simulated.drop(columns="id").set_index("label")
    table = objects.join(factors.rename(columns={"factor": "scale_factor"}), on="label")
    table = table.join(labels, on="label")
    table = table.assign(
        n_simulated=table["n_simulated"].fillna(0).astype(np.int32),
        n_grasps=[counts.get(label, 0) for label in table["label"]],
        in_evaluation_set=table["id"].isin(set(evaluation)),
    )
    return with_files(table, table["label"]).sort_values("label", ignore_index=True)


def simulated_grasps(grasps: pd.DataFrame, most: int) -> pd.DataFrame:
    """The first grasps of each object, at most `most`, that have a simulated label."""
    known = grasps[grasps["simulated_outcome"].notna()].sort_values(["label", "grasp"])
    return known.groupby("label").head(most)


def released_grasps(grasps: pd.DataFrame) -> pd.DataFrame:
    """Grasps as `RELEASED_GRASPS`, without `split`: the rotation of the hand is a quaternion."""
    if not len(grasps):
        return parquet.empty(RELEASED_GRASPS)
    poses = Grasps(grasps[SIMULATED_GRASPS.names]).poses
    turns = Rotation.from_matrix(poses[:, :3, :3]).as_quat(canonical=True)
    names = [f"hand_{part}" for part in ("qx", "qy", "qz", "qw")]
    return grasps.reset_index(drop=True).join(pd.DataFrame(turns, columns=names))


def in_files(
    rows: pd.DataFrame, split: str, most: int = ROWS
) -> Iterator[tuple[Path, pd.DataFrame]]:
    """Cut rows into `SPLIT-NNNNN-of-NNNNN.parquet` of about the same length, at least one file."""
    count = max(-(-len(rows) // most), 1)
    bounds = np.linspace(0, len(rows), count + 1).round().astype(int)
    for number in range(count):
        name = Path(f"{split}-{number:05d}-of-{count:05d}.parquet")
        yield name, rows.iloc[bounds[number] : bounds[number + 1]]
