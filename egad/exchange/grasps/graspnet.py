"""GraspNet arrays: the grasps of a gripper on an object as the 17 numbers of graspnetAPI."""

import math
from pathlib import Path
from typing import Any, cast

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad._util.arrays import Floats, Ints
from egad.errors import UserError
from egad.exchange import grasp_files as files
from egad.exchange.grasp_tables import simulated_by_object
from egad.exchange.hdf5 import check_key
from egad.exchange.new_folder import new_folder
from egad.exchange.parameters import GripperFormat, NamedGripper
from egad.grasps import Grasps, hand_poses
from egad.io import write_obj
from egad.sim import SimulationObject, held_when_shaken, with_outcome

LABELS = {"points", "offsets", "scores"}
KEYS = ({"rows"}, LABELS)
REFERENCE = (
    "its poses are in the frame of the mesh (files of egad) or of a camera (predictions), and it "
    "does not say which"
)
WIDTH = 17  # numbers of a grasp
DEPTH = 0.02  # metres; GraspNet has grasps with depths of 1, 2, 3 and 4 cm
HEIGHT = 0.02  # metres; of every finger in GraspNet
MAX_SCORE = 1.1  # a score is 1.1 less the friction that a grasp needs
FRICTIONS = (0.1, 1.0)
VIEWS = 300
CANDIDATES = (VIEWS, 12, 4)  # views, angles and depths at which points are labelled
STEPS = 14  # of 0.1, of friction coefficients
ROUNDED = 1e-3  # of friction coefficients in half precision


def graspnet_array(grasps: pd.DataFrame, opening: float, number: int) -> Floats:
    """The rows of a `GraspGroup`: score, width, height, depth, rotation, translation, object.

    The score of a grasp that held when it was shaken in simulation is GraspNet's: 1.1 less the
    smallest friction coefficient at which the contacts can hold the object, between 0.1 and 1. It
    is 0 for the others, and for grasps at which the open hand collides. Grasps with no known
    outcome are left out.

    Source: Fang et al., CVPR 2020, section 3.3; the layout, (n, 17) in metres, is graspnetAPI's: x
    is the approach, y the closing axis.
    """
    known = with_outcome(grasps)
    labelled = Grasps(known)
    poses = labelled.poses[:, :, [2, 0, 1, 3]]  # x approaches, y closes
    poses[:, :3, 3] -= DEPTH * poses[:, :3, 0]
    scores = MAX_SCORE - needed_friction(labelled).clip(*FRICTIONS)
    columns = [
        np.where(held_when_shaken(known), scores, 0.0),
        np.minimum(known["needed_opening"].to_numpy(dtype=np.float64), opening),
        np.full(len(known), HEIGHT),
        np.full(len(known), DEPTH),
        poses[:, :3, :3].reshape(-1, 9),
        poses[:, :3, 3],
        np.full(len(known), float(number)),
    ]
    return np.column_stack(columns)


def read(content: files.Content, options: files.ReadOptions) -> files.FileGrasps:
    """The grasps of one object, with the contacts `depth` ahead, at the ends of their fingers.

    The file is an array of graspnetAPI, or the labels of an object of GraspNet-1Billion.
    """
    if content.keys() >= LABELS:
        return _read_labels(cast("files.NpzFile", content), options)
    options.needed("reference", REFERENCE)
    rows = np.asarray(content["rows"], np.float64)
    if rows.ndim != 2 or rows.shape[1] != WIDTH:
        raise UserError(f"its array has the shape {rows.shape}; allowed: (n, {WIDTH})")
    ids = rows[:, -1].astype(np.int64).astype(str)
    rows = rows[ids == files.one_object(ids.tolist(), options, "objects")]
    matrices = np.tile(np.eye(4), (len(rows), 1, 1))
    matrices[:, :3, :3], matrices[:, :3, 3] = rows[:, 4:13].reshape(-1, 3, 3), rows[:, 13:16]
    depths = rows[:, 3] if options.depth is None else options.depth
    place = files.hand_in_frame(options.frame or "y x", depths)
    return files.file_grasps(matrices, place, openings=rows[:, 1], score=rows[:, 0])


def _read_labels(content: files.NpzFile, options: files.ReadOptions) -> files.FileGrasps:
    """The candidates of an object that have a friction coefficient: the positive `scores`.

    A candidate is a point, a view from a Fibonacci sphere, against which the hand approaches, an
    angle about it and a depth. It fails in collision, else succeeds if `max_friction` is given.

    Source: `loadGrasp` and `generate_views` of graspnetAPI, whose views are in single precision.
    """
    points = np.asarray(content["points"], np.float64).reshape(-1, 3)
    shape = (len(points), *CANDIDATES)
    kept, friction = _with_friction(content, shape, options.max_friction)
    angles, depths, widths = _take(content, "offsets", kept, (*shape, 3)).astype(np.float64).T
    point, view, *_ = np.unravel_index(kept, shape)
    height, turn = (2 * view + 1) / VIEWS - 1, view * np.pi * (np.sqrt(5) - 1)
    level = np.sqrt(1 - height**2)
    ahead = -np.stack([level * np.cos(turn), level * np.sin(turn), height], axis=1)
    flat = np.stack([np.sin(turn), -np.cos(turn), np.zeros(len(kept))], axis=1)
    closing = np.cos(angles)[:, None] * flat + np.sin(angles)[:, None] * np.cross(ahead, flat)
    success = np.full(len(kept), np.nan if options.max_friction is None else 1.0)
    if "collision" in content:
        success[_take(content, "collision", kept, shape)[:, 0].astype(bool)] = 0
    return files.file_grasps(
        hand_poses(points[point], closing, ahead)[:, :, [2, 0, 1, 3]],
        files.hand_in_frame(
            options.frame or "y x", depths if options.depth is None else options.depth
        ),
        openings=widths,
        success=success,
        score=MAX_SCORE - friction,
        note=f"{len(kept):,} of {math.prod(shape):,} candidates have a friction coefficient; the "
        f"hand collides at {int((success == 0).sum()):,} of them",
    )


def _with_friction(
    content: files.NpzFile, shape: tuple[int, ...], limit: float | None
) -> tuple[Ints, Floats]:
    """Which candidates of `shape` have a positive friction coefficient up to a limit, and which."""
    kept, values, counts = [np.empty(0, np.int64)], [np.empty(0)], np.zeros(STEPS, np.int64)
    for first, block in content.blocks("scores", shape):
        scores = block[:, 0].astype(np.float64)
        if not np.isfinite(scores).all():
            raise UserError("it has scores that are not finite")
        rows = np.flatnonzero((scores > 0) & (scores <= (limit or np.inf) + ROUNDED))
        steps = np.ceil(10 * (scores[rows] - ROUNDED)).clip(0, STEPS - 1)
        counts += np.bincount(steps.astype(np.int64), minlength=STEPS)
        if counts.sum() <= files.MAX_GRASPS:
            kept, values = [*kept, first + rows], [*values, scores[rows]]
    if counts.sum() > files.MAX_GRASPS:
        known = enumerate(np.cumsum(counts)[: STEPS - 1])
        listed = ", ".join(f"{step / 10:g}: {count:,}" for step, count in known if count)
        asked = f"give a lower `max_friction`, {files.ASKED['max_friction']} ({listed})"
        raise UserError(f"it has {counts.sum():,} grasps; at most {files.MAX_GRASPS:,}: {asked}")
    return np.concatenate(kept), np.concatenate(values)


def _take(content: files.NpzFile, name: str, kept: Ints, shape: tuple[int, ...]) -> NDArray[Any]:
    """The numbers of some candidates, (n, k)."""
    found = []
    for first, block in content.blocks(name, shape, 3 if name == "offsets" else 1):
        low, high = np.searchsorted(kept, (first, first + len(block)))
        found.append(block[kept[low:high] - first])
    return np.concatenate(found)


def needed_friction(grasps: Grasps) -> Floats:
    """The smallest friction at which contacts take a force along the axis, (n,)."""
    first, second = grasps.contacts[:, 0], grasps.contacts[:, 1]
    axes = (second - first) / np.linalg.norm(second - first, axis=1, keepdims=True)
    inward = np.stack([-grasps.normals[:, 0], grasps.normals[:, 1]], axis=1)
    cosines = np.einsum("nik,nk->ni", inward, axes).min(axis=1).clip(max=1.0)
    with np.errstate(divide="ignore"):
        tangents = np.sqrt(1 - cosines**2) / cosines
    return np.where(cosines > 0, tangents, np.inf)


def write_graspnet(folder: Path, label: str, grasps: pd.DataFrame, opening: float) -> None:
    """Write `LABEL.npy`, and the label with its number, in order of writing, to `objects.csv`."""
    listed = folder / "objects.csv"
    lines = listed.read_text() if listed.exists() else "object_id,label\n"
    number = lines.count("\n") - 1
    np.save(folder / f"{label}.npy", graspnet_array(grasps, opening, number))
    listed.write_text(f"{lines}{number},{label}\n")


def write(
    folder: Path, label: str, made: SimulationObject, grasps: pd.DataFrame, hand: NamedGripper
) -> None:
    """Write `LABEL.npy`, and `meshes/LABEL.obj`: see `egad.exchange.registry`."""
    write_graspnet(folder, label, grasps, hand.gripper.opening)
    write_obj(made.mesh, folder / f"meshes/{label}.obj")


def run(settings: GripperFormat, simulated_grasps: Path, out: Path) -> None:
    """Write an array for each object that has grasps, in the frame of its scaled mesh."""
    with new_folder(out) as folder:
        for label, rows in simulated_by_object(simulated_grasps):
            write_graspnet(folder, check_key(label), rows, settings.gripper.opening)
