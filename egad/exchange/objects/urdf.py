"""Objects as URDF: one link with the frame of the mesh.

Friction and convexity are not part of URDF. Bullet and Drake each read an extension of their own.
"""

from pathlib import Path
from xml.etree import ElementTree

from egad.exchange.object_files import (
    DRAKE,
    GREY,
    MeshFiles,
    moments,
    number_text,
    write_object_meshes,
    write_poses,
    xml_document,
)
from egad.geometry import MassProperties
from egad.sim import SimulationObject

# PhysX, which SAPIEN uses, leaves out vertices of a hull that are closer than 0.0007 to the others,
# in the unit of the file: in metres, parts shrink by 0.7 mm and more.
MILLIMETRE = 0.001


def write(folder: Path, name: str, made: SimulationObject, friction: float) -> None:
    """Write the folder `NAME`: `NAME.urdf`, meshes, parts of which are in mm, and `poses.json`."""
    files = write_object_meshes(folder / name, made, MILLIMETRE)
    text = urdf_text(name, files, made.physics, friction)
    (folder / name / f"{name}.urdf").write_text(text, encoding="utf-8")
    write_poses(folder / name, made)


def urdf_text(name: str, files: MeshFiles, physics: MassProperties, friction: float) -> str:
    """The description of one object as a robot of one link; mesh files are relative to it."""
    robot = ElementTree.Element("robot", {"name": name, "xmlns:drake": DRAKE})
    link = ElementTree.SubElement(robot, "link", name=name)
    contact = ElementTree.SubElement(link, "contact")
    ElementTree.SubElement(contact, "lateral_friction", value=number_text(friction))
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=number_text(*physics.com), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=number_text(physics.mass))
    tensor = {key: number_text(value) for key, value in moments(physics).items()}
    ElementTree.SubElement(inertial, "inertia", tensor)
    visual = ElementTree.SubElement(link, "visual")
    _mesh(visual, files.visual)
    material = ElementTree.SubElement(visual, "material", name="grey")
    ElementTree.SubElement(material, "color", rgba=number_text(*GREY, 1))
    for part in files.parts:
        collision = ElementTree.SubElement(link, "collision")
        mesh = _mesh(collision, part)
        if files.part_unit != 1:
            mesh.set("scale", number_text(*(files.part_unit,) * 3))
        ElementTree.SubElement(mesh, "drake:declare_convex")
        proximity = ElementTree.SubElement(collision, "drake:proximity_properties")
        for kind in ("mu_static", "mu_dynamic"):
            ElementTree.SubElement(proximity, f"drake:{kind}", value=number_text(friction))
    return xml_document(robot)


def _mesh(parent: ElementTree.Element, file: str) -> ElementTree.Element:
    geometry = ElementTree.SubElement(parent, "geometry")
    return ElementTree.SubElement(geometry, "mesh", filename=file)
