"""Objects as MJCF, for MuJoCo: one free body with the frame of the mesh."""

from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from egad.evalset import SimulationObject
from egad.exchange.object_meshes import GREY, MeshFiles, write_object_meshes
from egad.exchange.poses import write_poses
from egad.exchange.xml_text import moments, number_text, xml_document
from egad.geometry import MassProperties


class GeomGroups(NamedTuple):
    """The groups of geoms, as numbers in text."""

    visual: str
    collision: str


USUAL = GeomGroups("2", "3")  # MuJoCo does not draw group 3


def write(folder: Path, name: str, made: SimulationObject, friction: float) -> None:
    """Write the folder `NAME` with `NAME.xml`, its meshes and `poses.json`.

    Args:
        folder: Where the folder is made.
        name: Name of the object.
        made: The object.
        friction: Sliding friction.
    """
    files = write_object_meshes(folder / name, made)
    text = mjcf_text(name, files, made.physics, friction)
    (folder / name / f"{name}.xml").write_text(text, encoding="utf-8")
    write_poses(folder / name, made)


def mjcf_text(name: str, files: MeshFiles, physics: MassProperties, friction: float) -> str:
    """The description of one object.

    Args:
        name: Name of the model and its only body.
        files: Mesh files in metres, relative to the description.
        physics: Mass, center of mass and inertia about it.
        friction: Sliding friction.
    """
    model, assets, world = mjcf_model(name)
    body = ElementTree.SubElement(world, "body", name=name)
    ElementTree.SubElement(body, "freejoint")
    add_solid(assets, body, name, files, physics, friction, USUAL)
    return xml_document(model)


def mjcf_model(
    name: str,
) -> tuple[ElementTree.Element, ElementTree.Element, ElementTree.Element]:
    """A model with no bodies: its root, its assets and its world."""
    model = ElementTree.Element("mujoco", model=name)
    ElementTree.SubElement(model, "compiler", angle="radian", inertiafromgeom="false")
    assets = ElementTree.SubElement(model, "asset")
    return model, assets, ElementTree.SubElement(model, "worldbody")


def add_solid(
    assets: ElementTree.Element,
    body: ElementTree.Element,
    name: str,
    files: MeshFiles,
    physics: MassProperties,
    friction: float,
    groups: GeomGroups,
) -> None:
    """Give a body its inertia, its visual mesh and its convex parts.

    Args:
        assets: The assets of the model, which the meshes are added to.
        body: The body.
        name: Prefix of the names of meshes.
        files: Mesh files in metres, relative to the description.
        physics: Mass, center of mass and inertia about it.
        friction: Sliding friction.
        groups: The groups of its geoms.
    """
    inertial = ElementTree.SubElement(body, "inertial", pos=number_text(*physics.com))
    inertial.set("mass", number_text(physics.mass))
    inertial.set("fullinertia", number_text(*moments(physics).values()))
    look = {"contype": "0", "conaffinity": "0", "group": groups.visual}
    _geom(assets, body, f"{name}-visual", files.visual, look | {"rgba": number_text(*GREY, 1)})
    sticks = {"group": groups.collision, "friction": number_text(friction)}
    for part in files.parts:
        _geom(assets, body, f"{name}-{Path(part).stem}", part, sticks)


def _geom(
    assets: ElementTree.Element,
    body: ElementTree.Element,
    name: str,
    file: str,
    attributes: dict[str, str],
) -> None:
    # As a shell, a mesh may be arbitrarily thin; its inertia is not used.
    ElementTree.SubElement(assets, "mesh", name=name, file=file, inertia="shell")
    ElementTree.SubElement(body, "geom", {"type": "mesh", "mesh": name, **attributes})
