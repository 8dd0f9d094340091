"""Objects that `egad.export(..., format="urdf")` has written."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from defusedxml import ElementTree
from mani_skill.envs.scene import ManiSkillScene
from mani_skill.utils.building.actor_builder import ActorBuilder
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SURFACE, POSES = "visual.obj", "poses.json"


@dataclass(frozen=True)
class EgadObject:
    """An object in the frame of its mesh, metres.

    Attributes:
        folder: Has its files; its name is the label.
        friction: Sliding friction.
        com: (3,) center of mass.
        poses: (n, 4, 4) stable poses on a table whose top is z = 0.
        probabilities: (n,) of the stable poses; their sum is 1.
    """

    folder: Path
    friction: float
    com: Floats
    poses: Floats
    probabilities: Floats

    def builder(self, scene: ManiSkillScene) -> ActorBuilder:
        """A builder of its body; SAPIEN reads all but the friction from the URDF file."""
        loader = scene.create_urdf_loader()
        loader.set_material(self.friction, self.friction, 0.0)
        (builder,) = loader.parse(str(self.folder / f"{self.folder.name}.urdf"))["actor_builders"]
        return builder


def read_object(folder: Path) -> EgadObject:
    """Read `LABEL/LABEL.urdf` and `LABEL/poses.json`."""
    link = ElementTree.parse(folder / f"{folder.name}.urdf").getroot().find("link")
    poses = json.loads((folder / POSES).read_text(encoding="utf-8"))
    probabilities = np.array([pose["probability"] for pose in poses])
    return EgadObject(
        folder=folder,
        friction=float(link.find("contact/lateral_friction").get("value")),
        com=np.array(link.find("inertial/origin").get("xyz").split(), dtype=np.float64),
        poses=np.array([pose["transform"] for pose in poses]),
        probabilities=probabilities / probabilities.sum(),
    )


def read_objects(folder: str | Path) -> dict[str, EgadObject]:
    """All objects of a folder, which has a folder for each, by label."""
    found = sorted(Path(folder).glob(f"*/{POSES}"))
    if not found:
        raise FileNotFoundError(
            f"{folder} has no objects; make them: python examples/maniskill/prepare.py {folder}"
        )
    return {file.parent.name: read_object(file.parent) for file in found}
