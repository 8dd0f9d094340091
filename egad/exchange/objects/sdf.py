"""Objects as SDFormat, for Gazebo and Drake: one model with one link in the frame of the mesh."""

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

VERSION = "1.11"  # the first one in which a mesh can say that its convex hull is meant
MODEL = "model.sdf"


def write(folder: Path, name: str, made: SimulationObject, friction: float) -> None:
    """Write the folder `NAME` with `model.config`, `model.sdf`, its meshes and `poses.json`."""
    files = write_object_meshes(folder / name, made)
    (folder / name / "model.config").write_text(_config_text(name), encoding="utf-8")
    text = _text(name, files, made.physics, friction)
    (folder / name / MODEL).write_text(text, encoding="utf-8")
    write_poses(folder / name, made)


def _config_text(name: str) -> str:
    model = ElementTree.Element("model")
    _add(model, "name", name)
    _add(model, "version", "1.0")
    _add(model, "sdf", MODEL).set("version", VERSION)
    _add(model, "description", f"Object {name} for robot grasping, made by egad")
    return xml_document(model)


def _text(name: str, files: MeshFiles, physics: MassProperties, friction: float) -> str:
    root = ElementTree.Element("sdf", {"version": VERSION, "xmlns:drake": DRAKE})
    link = ElementTree.SubElement(ElementTree.SubElement(root, "model", name=name), "link")
    link.set("name", name)
    inertial = ElementTree.SubElement(link, "inertial")
    _add(inertial, "pose", number_text(*physics.com, 0, 0, 0))
    _add(inertial, "mass", number_text(physics.mass))
    tensor = ElementTree.SubElement(inertial, "inertia")
    for key, value in moments(physics).items():
        _add(tensor, key, number_text(value))
    visual = ElementTree.SubElement(link, "visual", name="visual")
    _mesh(visual, files.visual)
    material = ElementTree.SubElement(visual, "material")
    for kind in ("ambient", "diffuse"):
        _add(material, kind, number_text(*GREY, 1))
    for part in files.parts:
        _collision(link, part, friction)
    return xml_document(root)


def _collision(link: ElementTree.Element, file: str, friction: float) -> None:
    """Add a convex part, with its friction as Gazebo and as Drake read it."""
    collision = ElementTree.SubElement(link, "collision", name=Path(file).stem)
    mesh = _mesh(collision, file)
    mesh.set("optimization", "convex_hull")
    ElementTree.SubElement(mesh, "drake:declare_convex")
    surface = ElementTree.SubElement(ElementTree.SubElement(collision, "surface"), "friction")
    ode = ElementTree.SubElement(surface, "ode")
    for kind in ("mu", "mu2"):
        _add(ode, kind, number_text(friction))
    _add(ElementTree.SubElement(surface, "bullet"), "friction", number_text(friction))
    proximity = ElementTree.SubElement(collision, "drake:proximity_properties")
    for kind in ("mu_static", "mu_dynamic"):
        _add(proximity, f"drake:{kind}", number_text(friction))


def _mesh(parent: ElementTree.Element, file: str) -> ElementTree.Element:
    mesh = ElementTree.SubElement(ElementTree.SubElement(parent, "geometry"), "mesh")
    _add(mesh, "uri", file)
    return mesh


def _add(parent: ElementTree.Element, name: str, text: str) -> ElementTree.Element:
    child = ElementTree.SubElement(parent, name)
    child.text = text
    return child
