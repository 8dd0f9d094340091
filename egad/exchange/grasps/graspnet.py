"""GraspNet arrays: the grasps of a gripper on an object as the 17 numbers of graspnetAPI."""

from pathlib import Path

import numpy as np
import pandas as pd

from egad._util.arrays import Floats
from egad.errors import UserError
from egad.exchange import grasp_files as files
from egad.exchange.grasp_tables import simulated_by_object
from egad.exchange.hdf5 import check_key
from egad.exchange.new_folder import new_folder
from egad.exchange.parameters import GripperFormat, NamedGripper
from egad.grasps import Grasps
from egad.io import write_obj
from egad.sim import SimulationObject, held_when_shaken, with_outcome

KEYS = ({"rows"},)
REFERENCE = (
    "its poses are in the frame of the mesh (files of egad) or of a camera (predictions), and it "
    "does not say which"
)
WIDTH = 17  # numbers of a grasp
DEPTH = 0.02  # metres; GraspNet has grasps with depths of 1, 2, 3 and 4 cm
HEIGHT = 0.02  # metres; of every finger in GraspNet
MAX_SCORE = 1.1  # a score is 1.1 less the friction that a grasp needs
FRICTIONS = (0.1, 1.0)


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
    """The grasps of one object, with the contacts `depth` ahead, at the ends of their fingers."""
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
