"""Grasps of a parallel-jaw hand as arrays and as a table: what the functions of `egad` return."""

from typing import Self

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from egad._util.arguments import check_array
from egad._util.arrays import Flags, Floats
from egad._util.display import Picture, draw, facts_html
from egad.errors import UserError
from egad.grasps.poses import hand_poses
from egad.tables.columns import vector_names

POINTS = ("center", "contact0", "contact1")
DIRECTIONS = ("axis", "approach", "normal0", "normal1")
RIGID = 1e-6  # largest entry of R^T R - 1


class Grasps:
    """Grasps of a parallel-jaw hand, in the frame of the object, metres.

    `len(grasps)`, `grasps[:10]`, `grasps[grasps.quality > 0.002]` and `grasps[order]` work as for
    arrays, and give `Grasps` again.
    """

    def __init__(self, table: pd.DataFrame) -> None:
        """Wrap a table.

        Args:
            table: One row per grasp, with the columns of `tables.grasping.GRASPS`; `id` and `label`
                may be absent.
        """
        self._table = table.reset_index(drop=True)

    def __len__(self) -> int:
        return len(self._table)

    def __getitem__(self, chosen: int | slice | ArrayLike) -> Self:
        """Some of the grasps: an index, a slice, an array of indices, or (n,) booleans."""
        if not isinstance(chosen, slice):
            given = np.asarray(chosen)
            chosen = given if given.size or given.dtype == bool else given.astype(np.int64)
        index = np.arange(len(self))[chosen]
        return type(self)(self._table.iloc[np.atleast_1d(index)])

    def __repr__(self) -> str:
        parts = [f"{len(self)} grasps" if len(self) != 1 else "1 grasp"]
        parts += [f"{name}: {value}" for name, value in self._facts().items()]
        return f"Grasps({', '.join(parts)})"

    def _repr_html_(self) -> str:
        return facts_html("Grasps", {"grasps": len(self), **self._facts()})

    def _facts(self) -> dict[str, str]:
        """How many are free of collision and do not slip, and how wide and good they are."""
        if not len(self):
            return {}
        widths = 1000 * self.widths
        of_jaws = {"widths": f"{widths.min():.1f} to {widths.max():.1f} mm"} if widths.any() else {}
        if "quality" not in self._table:
            return of_jaws
        return {
            "collision-free": str(np.count_nonzero(self.collision_free)),
            "without slip" if of_jaws else "that hold": str(np.count_nonzero(self.quality)),
            **of_jaws,
            "best quality": f"{self.quality.max():.3g}",
        }

    def plot(self) -> Picture:
        """Draw histograms of nominal and robust quality, with and without a collision.

        `egad.view(mesh, grasps, gripper)` shows the grasps in 3D.

        Returns:
            A picture that a notebook shows; `save("quality.svg")` writes it.

        Raises:
            UserError: There are no grasps.
        """
        if not len(self):
            raise UserError("there are no grasps to plot")
        return draw("grasps", "collision_chart", self._table)

    @property
    def poses(self) -> Floats:
        """(n, 4, 4) poses of the hand.

        They map from the frame of the hand to that of the object. The origin of the hand is midway
        between the contacts, x is the closing axis, z the approach direction.
        """
        return hand_poses(*(vectors(self._table, name) for name in ("center", "axis", "approach")))

    @property
    def contacts(self) -> Floats:
        """(n, 2, 3) contact points, metres."""
        return np.stack([vectors(self._table, f"contact{i}") for i in (0, 1)], axis=1)

    @property
    def normals(self) -> Floats:
        """(n, 2, 3) outward unit normals of the surface at the contacts."""
        return np.stack([vectors(self._table, f"normal{i}") for i in (0, 1)], axis=1)

    @property
    def widths(self) -> Floats:
        """(n,) distances between the two contacts, metres."""
        return self._column("width")

    @property
    def quality(self) -> Floats:
        """(n,) Ferrari-Canny quality; 0 if the grasp slips."""
        return self._column("quality")

    @property
    def robust_quality(self) -> Floats:
        """(n,) mean Ferrari-Canny quality over perturbed copies of the grasp."""
        return self._column("robust_quality")

    @property
    def source_success(self) -> Floats:
        """(n,) 1 or 0: the label of the file that the grasps were read from; NaN without one."""
        return self._column("source_success")

    @property
    def source_score(self) -> Floats:
        """(n,) score of the file that the grasps were read from; NaN without one."""
        return self._column("source_score")

    @property
    def collision_free(self) -> Flags:
        """(n,) whether the open hand reaches the grasp without touching the object."""
        return self._column("collision_free").astype(bool)

    def sorted_by(self, column: str = "quality") -> Self:
        """The grasps in descending order of a column; ties keep their order.

        Raises:
            UserError: There is no such column.
        """
        if column not in self._table:
            names = ", ".join(map(str, self._table.columns))
            raise UserError(f"grasps have no column {column!r}; allowed: {names}")
        return type(self)(self._table.sort_values(column, ascending=False, kind="stable"))

    def of(self, label: str) -> Self:
        """The grasps of one object of a dataset, by its label.

        Raises:
            UserError: The grasps are of a single object, or there are none with this label.
        """
        if "label" not in self._table:
            raise UserError("these grasps are of a single object, which has no label")
        rows = self._table[self._table["label"] == label]
        if rows.empty:
            raise UserError(f"there are no grasps of an object {label!r}")
        return type(self)(rows)

    def transformed(self, matrix: ArrayLike) -> Self:
        """The same grasps in another frame.

        Args:
            matrix: (4, 4) rigid transform from the frame of the object to the new one.

        Raises:
            UserError: The matrix is not a rigid transform.
        """
        whole = check_array("matrix", matrix, (4, 4), "a (4, 4) array of finite numbers")
        if not are_rigid(whole[None]).all():
            raise UserError(
                "the transform is not rigid: only a rotation and a translation are allowed"
            )
        rotation, shift = whole[:3, :3], whole[:3, 3]
        moved = self._table.copy()
        for name in POINTS:
            moved[vector_names(name)] = vectors(moved, name) @ rotation.T + shift
        for name in DIRECTIONS:
            moved[vector_names(name)] = vectors(moved, name) @ rotation.T
        return type(self)(moved)

    def to_frame(self) -> pd.DataFrame:
        """A copy of the table: one row per grasp, columns as in `results/README.md`."""
        return self._table.copy()

    def _column(self, name: str) -> Floats:
        if name not in self._table:
            raise UserError(
                f"these grasps have no {name}: it is computed for sampled grasps, and for those "
                "that are read with a mesh and a gripper"
            )
        return self._table[name].to_numpy(dtype=np.float64)


def vectors(frame: pd.DataFrame, name: str) -> Floats:
    """The columns `NAME_x`, `NAME_y`, `NAME_z` as (n, 3)."""
    return np.asarray(frame[vector_names(name)], dtype=np.float64).reshape(-1, 3)


def vector_columns(name: str, values: Floats) -> dict[str, Floats]:
    """The inverse of `vectors`."""
    return dict(zip(vector_names(name), values.T, strict=True))


def are_rigid(matrices: Floats, tolerance: float = RIGID) -> Flags:
    """Whether each of (n, 4, 4) transforms is a rotation and a translation, (n,)."""
    turns = matrices[:, :3, :3]
    with np.errstate(invalid="ignore"):
        off = np.abs(np.swapaxes(turns, 1, 2) @ turns - np.eye(3)).max(axis=(1, 2), initial=0)
        last = np.abs(matrices[:, 3] - [0, 0, 0, 1]).max(axis=1, initial=0)
        return np.asarray((off <= tolerance) & (np.linalg.det(turns) > 0) & (last <= tolerance))
