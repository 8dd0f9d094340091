"""Objects for simulators: meshes, URDF, MJCF and stable poses."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from egad.evalset import SimulationObject
from egad.exchange.meshes import write_obj
from egad.geometry import MassProperties

Floats = NDArray[np.float64]

VISUAL = "visual.obj"
GREY = "0.72 0.74 0.78 1"
VISUAL_GROUP, COLLISION_GROUP = "2", "3"  # MuJoCo's usual groups: 3 is not drawn
# MuJoCo's own values, in metres: only the first, sliding, is a setting here.
TORSION, ROLLING = 0.005, 0.0001


def write_simulation_object(
    folder: Path, name: str, made: SimulationObject, friction: float
) -> None:
    """Write `NAME.urdf`, `NAME.xml` (MJCF), `visual.obj`, `parts/` and `poses.json`.

    Args:
        folder: A new folder.
        name: Of the object.
        made: What is written.
        friction: Sliding friction.
    """
    (folder / "parts").mkdir(parents=True)
    write_obj(made.mesh, folder / VISUAL)
    parts = [f"parts/part-{number:03d}.obj" for number in range(len(made.parts))]
    for part, file in zip(made.parts, parts, strict=True):
        write_obj(part, folder / file)
    for ending, describe in (("urdf", urdf), ("xml", mjcf)):
        text = describe(name, VISUAL, parts, made.physics, friction)
        (folder / f"{name}.{ending}").write_text(text, encoding="utf-8")
    text = json.dumps(_poses(made), indent=1) + "\n"
    (folder / "poses.json").write_text(text, encoding="utf-8")


def _poses(made: SimulationObject) -> list[dict[str, Any]]:
    return [
        {
            "probability": pose.probability,
            "transform": pose.matrix.tolist(),
            "face_normal": pose.normal.tolist(),
            "height": pose.height,
            "margin": float(np.degrees(pose.margin)),
        }
        for pose in made.poses
    ]


def urdf(
    name: str, visual: str, parts: Sequence[str], physics: MassProperties, friction: float
) -> str:
    """One link with the frame of the mesh (URDF, with Bullet's extension for friction).

    Args:
        name: Of the robot and its only link.
        visual: File of the visual mesh, relative to the description; metres.
        parts: Files of the convex parts.
        physics: Mass, center of mass and inertia about it.
        friction: Sliding friction.
    """
    robot = ElementTree.Element("robot", name=name)
    link = ElementTree.SubElement(robot, "link", name=name)
    contact = ElementTree.SubElement(link, "contact")
    ElementTree.SubElement(contact, "lateral_friction", value=_text(friction))
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_text(*physics.com), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=_text(physics.mass))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    moments = dict(zip(names, map(_text, _moments(physics)), strict=True))
    ElementTree.SubElement(inertial, "inertia", moments)
    look = _mesh(ElementTree.SubElement(link, "visual"), visual)
    material = ElementTree.SubElement(look, "material", name="grey")
    ElementTree.SubElement(material, "color", rgba=GREY)
    for part in parts:
        _mesh(ElementTree.SubElement(link, "collision"), part)
    return _document(robot)


def mjcf(
    name: str, visual: str, parts: Sequence[str], physics: MassProperties, friction: float
) -> str:
    """One free body with the frame of the mesh (MJCF); arguments as for `urdf`."""
    model = ElementTree.Element("mujoco", model=name)
    ElementTree.SubElement(model, "compiler", angle="radian", inertiafromgeom="false")
    assets = ElementTree.SubElement(model, "asset")
    body = ElementTree.SubElement(ElementTree.SubElement(model, "worldbody"), "body", name=name)
    ElementTree.SubElement(body, "freejoint")
    inertial = ElementTree.SubElement(body, "inertial", pos=_text(*physics.com))
    inertial.set("mass", _text(physics.mass))
    inertial.set("fullinertia", _text(*_moments(physics)))
    look = {"contype": "0", "conaffinity": "0", "group": VISUAL_GROUP, "rgba": GREY}
    _geom(assets, body, f"{name}-visual", visual, look)
    sticks = {"group": COLLISION_GROUP, "friction": _text(friction, TORSION, ROLLING)}
    for part in parts:
        _geom(assets, body, f"{name}-{Path(part).stem}", part, sticks)
    return _document(model)


def _mesh(parent: ElementTree.Element, file: str) -> ElementTree.Element:
    geometry = ElementTree.SubElement(parent, "geometry")
    ElementTree.SubElement(geometry, "mesh", filename=file)
    return parent


def _geom(
    assets: ElementTree.Element,
    body: ElementTree.Element,
    name: str,
    file: str,
    attributes: dict[str, str],
) -> None:
    # As a shell a mesh may be ever so thin; its inertia is not used.
    ElementTree.SubElement(assets, "mesh", name=name, file=file, inertia="shell")
    ElementTree.SubElement(body, "geom", {"type": "mesh", "mesh": name, **attributes})


def _moments(physics: MassProperties) -> Iterable[float]:
    tensor = physics.inertia
    return (*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2])


def _text(*values: float) -> str:
    return " ".join(repr(float(value)) for value in values)


def _document(root: ElementTree.Element) -> str:
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
