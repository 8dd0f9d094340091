"""Stable poses of an object as `poses.json`."""

import json
from pathlib import Path

import numpy as np

from egad.evalset import SimulationObject

POSES = "poses.json"


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
