"""Labelled scenes from folders, decoded one by one when they are asked for."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad._util.arrays import Floats
from egad._util.display import table_html
from egad._util.files import as_path
from egad._util.parameters import from_file
from egad.bench import POINT_SIGMA, WORKSPACE, SceneKind
from egad.detectors import NoiseName, Observation, View
from egad.errors import TableError, UserError, check_name
from egad.grippers import Gripper
from egad.learning.images import SPLITS, check_splits, pose_matrix, view_of
from egad.learning.shards import rows_of, shard_files
from egad.random import entropy
from egad.tables import parquet
from egad.tables.columns import POSE_PARTS
from egad.tables.parquet import RowGroups
from egad.tables.scenes import SCENE_GRASPS, SCENES

KEPT = 64  # shards whose grasps stay in memory
MAKERS = "`egad.make_scenes` or the workflow (targets.scenes)"
TABLES = ("scenes", "grasps")
INDEX = ["scene", "kind", "split", "objects", "noise"]


@dataclass(frozen=True, eq=False, repr=False)
class LabelledScene:
    """Objects on a table, depth images of them, and grasps labelled in simulation.

    Attributes:
        number: Number of the scene in its folder.
        kind: How the objects lie: packed or pile.
        split: train, validation or test.
        objects: Ids of the objects.
        factors: Their sizes / those of the meshes scaled to the gripper.
        placements: Of each object, the (4, 4) transform from its mesh, in this size, to the world;
            the table is z = 0.
        noise: Noise of the depth images.
        grasps: Columns of `egad.tables.scenes.SCENE_GRASPS`.
    """

    number: int
    kind: SceneKind
    split: str
    objects: tuple[str, ...]
    factors: tuple[float, ...]
    placements: tuple[Floats, ...]
    noise: NoiseName
    grasps: pd.DataFrame
    _row: dict[str, Any]

    def __repr__(self) -> str:
        held = int(self.grasps["success"].sum())
        return (
            f"LabelledScene({self.kind}, {len(self.objects)} objects, {self.view_count} views, "
            f"{held} of {len(self.grasps)} grasps held)"
        )

    def _repr_html_(self) -> str:
        return table_html(repr(self), self.grasps)

    @property
    def view_count(self) -> int:
        """How many depth images there are."""
        return len(self._row["depth"])

    @cached_property
    def views(self) -> tuple[View, ...]:
        """The depth images, with masks: k for the k-th object, from 1; TableError if damaged."""
        return tuple(map(self._view, range(self.view_count)))

    def observation(self, views: Sequence[int] | None = None) -> Observation:
        """What cameras see: depth images, their point cloud and TSDF, as detectors get them.

        There is no image from straight above: the first of the views stands for it. `views` are
        numbers, all if None. TableError if one is damaged; UserError if there is none.
        """
        chosen = range(self.view_count) if views is None else [int(number) for number in views]
        if not chosen or not all(0 <= number < self.view_count for number in chosen):
            raise UserError(
                f"views are {views}; allowed: some of the numbers 0 to {self.view_count - 1}"
            )
        seen = tuple(self.views[n] if "views" in self.__dict__ else self._view(n) for n in chosen)
        if self.noise != "points":
            return Observation(seen[0], seen, WORKSPACE)
        seed = entropy(self.number, "points", *self.objects)
        return Observation(seen[0], seen, WORKSPACE, POINT_SIGMA, seed)

    @property
    def poses(self) -> Floats:
        """Poses of the hand at the grasps, (n, 4, 4), in the order of `grasps`."""
        rows = self.grasps[list(POSE_PARTS)].to_numpy(np.float64)
        return np.array([pose_matrix(row) for row in rows]).reshape(-1, 4, 4)

    def _view(self, number: int) -> View:
        row = self._row
        image = row | {name: row[name][number] for name in ("depth", "mask")}
        return view_of(image, np.reshape(row["cameras"], (-1, len(POSE_PARTS)))[number])


class SceneDataset:
    """All labelled scenes of some folders, as one set; threads may share it.

    Attributes:
        folders: Where they are.
        gripper: The gripper that tried the grasps.
        gripper_name: Its name in the settings that the scenes were made with.
        index: One row per scene: `scene`, its number in its folder; `kind`, `split`, `objects` and
            `noise`; `views`, how many depth images there are; `grasps`, how many there are, and
            `positive`, how many of these succeeded; `shard`, `group` and `row`, where it is stored,
            shards counted through all folders.
    """

    def __init__(self, folders: Sequence[Path], keep: object = None) -> None:
        """Look through `scenes-N.parquet` and `grasps-N.parquet` of each folder; decode nothing.

        Args:
            folders: All of one gripper.
            keep: An object that must live as long as the files are read.

        Raises:
            UserError: Some are missing, are not all of one set, or do not name their gripper;
                folders are of several grippers, or an object is in two splits.
            TableError: One cannot be read, or is not of this layout.
        """
        self.folders, self._keep = tuple(folders), keep
        sets = [shard_files(folder, TABLES, MAKERS) for folder in folders]
        self.gripper_name, self.gripper = _same_gripper(sets)
        pairs = [pair for each in sets for pair in each]
        self._paths = [scenes for scenes, _ in pairs]
        self._files = [RowGroups(scenes, SCENES.names) for scenes, _ in pairs]
        for _, grasps in pairs:
            parquet.check_columns(grasps, SCENE_GRASPS.names)
        self._grasps = lru_cache(KEPT)(lambda shard: parquet.read(pairs[shard][1], SCENE_GRASPS))
        parts = [self._indexed(shard) for shard in range(len(pairs))]
        self.index = pd.concat([part for part in parts if len(part)] or parts[:1])
        self.index = self.index.reset_index(drop=True)
        check_splits(self.index, self.source)

    def __reduce__(self) -> tuple[type["SceneDataset"], tuple[Sequence[Path]]]:
        return SceneDataset, (self.folders,)

    @property
    def source(self) -> str:
        """The folders, as messages name them."""
        return ", ".join(map(str, self.folders))

    def __repr__(self) -> str:
        grasps, positive = (int(self.index[name].sum()) for name in ("grasps", "positive"))
        return f"SceneDataset({len(self)} scenes, {grasps} grasps, {positive} positive)"

    def _repr_html_(self) -> str:
        return table_html(repr(self), self.index.drop(columns=["shard", "group", "row"]))

    def __len__(self) -> int:
        return len(self.index)

    def indices(self, split: str) -> NDArray[np.int64]:
        """Rows of the index in a split; UserError if there are none, or no such split."""
        check_name("split", split, SPLITS)
        found = np.flatnonzero(self.index["split"] == split)
        if len(found) == 0:
            raise UserError(f"{self.source}: no scene in the split {split}")
        return found

    def scene(self, number: int) -> LabelledScene:
        """The scene of a row of the index; IndexError if none, TableError if damaged."""
        if not 0 <= number < len(self):
            raise IndexError(f"scene {number} of {len(self)}")
        shard, group, place = (self.index[name].iloc[number] for name in ("shard", "group", "row"))
        found = self._files[shard].read(group, SCENES.names).iloc[place]
        row = {str(name): value for name, value in found.items()}
        grasps = self._grasps(shard)
        try:
            placements = np.reshape(row["placements"], (len(row["objects"]), len(POSE_PARTS)))
            views = {len(row["depth"]), len(row["mask"]), len(row["cameras"]) / len(POSE_PARTS)}
            if len(views) > 1:
                raise ValueError("its lists of views are of unequal lengths")
            return LabelledScene(
                number=int(row["scene"]),
                kind=row["kind"],
                split=row["split"],
                objects=tuple(row["objects"]),
                factors=tuple(map(float, row["factors"])),
                placements=tuple(map(pose_matrix, placements)),
                noise=row["noise"],
                grasps=grasps[grasps["scene"] == row["scene"]].reset_index(drop=True),
                _row=row,
            )
        except (ValueError, TypeError) as error:
            raise TableError(f"{self._paths[shard]}: scene {row['scene']}: {error}") from error

    def _indexed(self, shard: int) -> pd.DataFrame:
        rows = rows_of([self._paths[shard]], SCENES, [*INDEX, "cameras"])
        success = self._grasps(shard).groupby("scene")["success"]
        counts = {"grasps": success.size(), "positive": success.sum()}
        sizes = self._files[shard].sizes
        return rows[INDEX].assign(
            views=rows["cameras"].map(len).astype(int) // len(POSE_PARTS),
            **{
                name: rows["scene"].map(each).fillna(0).astype(int) for name, each in counts.items()
            },
            shard=shard,
            group=np.repeat(np.arange(len(sizes)), sizes),
            row=np.concatenate([np.arange(size) for size in [0, *sizes]]),
        )


def _same_gripper(sets: Sequence[Sequence[tuple[Path, ...]]]) -> tuple[str, Gripper]:
    """The gripper of some sets of shards, and its name in the first of them."""
    found = []
    for shards in sets:
        path = shards[0][0]
        notes = parquet.notes(path)
        if not isinstance(notes.get("gripper"), str) or not isinstance(notes.get("hand"), dict):
            raise UserError(f"{path}: does not say for which gripper it is; make the scenes again")
        try:
            found.append((notes["gripper"], from_file(Gripper, notes["hand"])))
        except UserError as error:
            raise TableError(f"{path}: its gripper is not valid: {error}") from error
    first, *others = found
    for path, (name, gripper) in zip([each[0][0].parent for each in sets[1:]], others, strict=True):
        if gripper != first[1]:
            raise UserError(
                f"{path}: scenes for {name}, but {sets[0][0][0].parent} is for {first[0]} or for "
                "other settings of it; use scenes of the same gripper"
            )
    return first


def load_scenes(folder: str | Path | Sequence[str | Path]) -> SceneDataset:
    """Read labelled scenes; images are decoded when they are asked for.

    Args:
        folder: One folder, or several, which become one set.

    Raises:
        UserError: Shards are missing, or are not all of one set; folders are of several grippers;
            an object is in two splits.
        TableError: A shard is damaged.
    """
    given = [folder] if isinstance(folder, str | Path) else list(folder)
    return SceneDataset([as_path("folder", each) for each in given])
