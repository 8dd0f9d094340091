"""Files of an object for simulators that several formats have: meshes and stable poses."""

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from egad.geometry import SimulationObject
from egad.io import write_obj

VISUAL, PARTS, POSES = "visual.obj", "parts", "poses.json"
GREY = (0.72, 0.74, 0.78)  # sRGB


class MeshFiles(NamedTuple):
    """Files as a description names them: surface, metres, and convex parts, `part_unit` metres."""

    visual: str
    parts: tuple[str, ...]
    part_unit: float = 1.0

    def within(self, folder: str) -> "MeshFiles":
        """The same files, seen from the folder that holds this folder."""
        parts = tuple(f"{folder}/{part}" for part in self.parts)
        return MeshFiles(f"{folder}/{self.visual}", parts, self.part_unit)


def write_object_meshes(folder: Path, made: SimulationObject, part_unit: float = 1.0) -> MeshFiles:
    """Write `visual.obj`, in metres, and `parts/part-NNN.obj`, in `part_unit` metres."""
    (folder / PARTS).mkdir(parents=True)
    write_obj(made.mesh, folder / VISUAL)
    parts = tuple(f"{PARTS}/part-{number:03d}.obj" for number in range(len(made.parts)))
    for part, file in zip(made.parts, parts, strict=True):
        scaled = part if part_unit == 1 else part.copy().apply_scale(1 / part_unit)
        write_obj(scaled, folder / file)
    return MeshFiles(VISUAL, parts, part_unit)


def write_poses(folder: Path, made: SimulationObject) -> None:
    """Write `poses.json` into an existing folder, the most probable pose first."""
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
