"""Objects that `egad.export(..., format="simulation")` or a bundle of the pipeline has written."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import sapien
from defusedxml import ElementTree
from mani_skill.utils.building.actor_builder import ActorBuilder
from numpy.typing import NDArray
from sapien.physx import PhysxMaterial

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class EgadObject:
    """An object in the frame of its mesh; units are metres and kilograms.

    Attributes:
        label: Name, such as `A0`.
        visual: File of the true surface.
        parts: Files of the convex parts that replace it in contacts.
        friction: Sliding friction.
        mass: Of the whole object.
        com: (3,) center of mass.
        inertia: (3, 3) about the center of mass.
        poses: (n, 4, 4) stable poses on a table whose top is z = 0.
        probabilities: (n,) of the stable poses; their sum is 1.
    """

    label: str
    visual: Path
    parts: tuple[Path, ...]
    friction: float
    mass: float
    com: Floats
    inertia: Floats
    poses: Floats
    probabilities: Floats

    @property
    def mass_frame(self) -> tuple[sapien.Pose, Floats]:
        """Pose of the principal axes of inertia at the center of mass, and the (3,) moments."""
        moments, axes = np.linalg.eigh(self.inertia)
        matrix = np.eye(4)
        matrix[:3, :3] = axes * np.linalg.det(axes)  # a rotation, not a reflection
        matrix[:3, 3] = self.com
        return sapien.Pose(matrix), moments

    def add_to(self, builder: ActorBuilder) -> None:
        """Give an actor the convex parts, friction, mass and inertia, and a visual if it is drawn.

        Args:
            builder: Of the actor.
        """
        material = PhysxMaterial(self.friction, self.friction, 0.0)
        for part in self.parts:
            builder.add_convex_collision_from_file(str(part), material=material)
        if builder.scene.can_render():
            builder.add_visual_from_file(
                str(self.visual),
                material=sapien.render.RenderMaterial(base_color=[0.1, 0.3, 0.8, 1]),
            )
        frame, moments = self.mass_frame
        builder.set_mass_and_inertia(self.mass, frame, moments)


def read_object(folder: Path) -> EgadObject:
    """Read `LABEL/LABEL.urdf` and `LABEL/poses.json`.

    Args:
        folder: Of the object, named as its label.
    """
    link = ElementTree.parse(folder / f"{folder.name}.urdf").getroot().find("link")
    inertial = link.find("inertial")
    ixx, iyy, izz, ixy, ixz, iyz = (
        float(inertial.find("inertia").get(name))
        for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    )
    poses = json.loads((folder / "poses.json").read_text(encoding="utf-8"))
    probabilities = np.array([pose["probability"] for pose in poses])
    files = [mesh.get("filename") for mesh in link.findall("collision/geometry/mesh")]
    return EgadObject(
        label=folder.name,
        visual=folder / link.find("visual/geometry/mesh").get("filename"),
        parts=tuple(folder / file for file in files),
        friction=float(link.find("contact/lateral_friction").get("value")),
        mass=float(inertial.find("mass").get("value")),
        com=np.array(inertial.find("origin").get("xyz").split(), dtype=np.float64),
        inertia=np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]]),
        poses=np.array([pose["transform"] for pose in poses]),
        probabilities=probabilities / probabilities.sum(),
    )


def read_objects(folder: str | Path) -> dict[str, EgadObject]:
    """All objects of a folder, by label.

    Args:
        folder: Has a folder `LABEL` for each object.

    Raises:
        FileNotFoundError: There is no object in it.
    """
    found = sorted(Path(folder).glob("*/poses.json"))
    if not found:
        raise FileNotFoundError(
            f"{folder} has no objects; make them: python examples/maniskill/prepare.py {folder}"
        )
    return {file.parent.name: read_object(file.parent) for file in found}
