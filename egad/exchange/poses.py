"""Stable poses of an object as `poses.json`."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from egad._util.arrays import Floats
from egad.errors import UserError
from egad.evalset import SimulationObject
from egad.geometry import StablePose

POSES = "poses.json"
ON_TABLE = 1e-6  # m: vertices at most this far from the table belong to the resting face


def write_poses(folder: Path, made: SimulationObject) -> None:
    """Write `poses.json`, the most probable pose first.

    Args:
        folder: An existing folder.
        made: The object.
    """
    poses = [
        {
            "probability": pose.probability,
            "transform": pose.matrix.tolist(),
            "face_normal": pose.normal.tolist(),
            "height": pose.height,
            "margin": float(np.degrees(pose.margin)),
        }
        for pose in made.poses
    ]
    (folder / POSES).write_text(json.dumps(poses, indent=1) + "\n", encoding="utf-8")


def read_poses(folder: Path, mesh: trimesh.Trimesh, com: Floats) -> tuple[StablePose, ...]:
    """The poses that `write_poses` wrote.

    Args:
        folder: Folder of the object.
        mesh: Its surface, metres.
        com: Its center of mass in the frame of the mesh, (3,).

    Raises:
        UserError: The file is missing or damaged.
    """
    path = folder / POSES
    try:
        rows = json.loads(path.read_text(encoding="utf-8"))
        return tuple(_pose(row, mesh, com) for row in rows)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: missing or damaged; make the bundle again") from error


def _pose(row: dict[str, Any], mesh: trimesh.Trimesh, com: Floats) -> StablePose:
    matrix = np.array(row["transform"], dtype=np.float64)
    heights = trimesh.transform_points(mesh.vertices, matrix)[:, 2]
    return StablePose(
        probability=float(row["probability"]),
        face=np.flatnonzero(heights < ON_TABLE),
        normal=np.array(row["face_normal"], dtype=np.float64),
        rotation=matrix[:3, :3],
        height=float(row["height"]),
        margin=float(np.radians(row["margin"])),
        center=com,
    )
