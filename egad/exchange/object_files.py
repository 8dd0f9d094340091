"""What formats of objects for simulators share: meshes, stable poses, and text of XML."""

import json
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from egad.geometry import MassProperties
from egad.io import write_obj
from egad.sim import SimulationObject

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


DRAKE = "http://drake.mit.edu"  # namespace of what Drake adds to URDF and SDFormat
# kg m2: MuJoCo takes no principal moment below 1e-14, that of a ball of 0.9 mm at 400 kg/m3. A body
# with a larger moment starts and stops turning more slowly, and falls as before.
MIN_MOMENT = 2e-14
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def number_text(*values: float) -> str:
    """Numbers separated by spaces, with enough digits to read them back."""
    return " ".join(repr(float(value)) for value in values)


def moments(physics: MassProperties) -> dict[str, float]:
    """The moments about the center of mass, kg m2, by name, at least 2e-14 for simulators."""
    tensor = physics.inertia
    principal, axes = np.linalg.eigh(tensor)
    if principal.min() < MIN_MOMENT:
        tensor = (axes * np.maximum(principal, MIN_MOMENT)) @ axes.T
    values = (*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2])
    return {name: float(value) for name, value in zip(MOMENTS, values, strict=True)}


def xml_document(root: ElementTree.Element) -> str:
    """The document as indented text."""
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
