"""Robots as URDF, the only format of robots that PyBullet reads."""

from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from scipy.spatial import ConvexHull, HalfspaceIntersection
from scipy.spatial.transform import Rotation
from trimesh.exchange.obj import export_obj

from egad._util.arrays import Floats
from egad.sim.robot import EFFORT, Box, HullShape, Link, Robot, Vector, shape_mesh


def to_urdf(robot: Robot) -> str:
    """The robot as URDF, with its hulls as meshes in the files of `hull_files`."""
    root = Element("robot", name="robot")
    for link in robot.links:
        _write_link(root, link)
    for joint in robot.joints:
        element = SubElement(root, "joint", name=joint.child, type=joint.kind)
        _write_origin(element, joint.origin, joint.turn)
        SubElement(element, "parent", link=joint.parent)
        SubElement(element, "child", link=joint.child)
        if joint.kind != "fixed":
            SubElement(element, "axis", xyz=_text(joint.axis))
            low, high = map(repr, joint.limits)
            SubElement(element, "limit", lower=low, upper=high, effort=f"{EFFORT:g}", velocity="10")
    ElementTree.indent(root)  # PyBullet cuts lines of more than 8192 characters
    return ElementTree.tostring(root, encoding="unicode")


def hull_files(robot: Robot, margin: float) -> dict[str, str]:
    """The hulls of a robot as OBJ files by name, shrunk by a margin, metres; thin ones by less."""
    files = {}
    for link in robot.links:
        for number, shape in enumerate(link.shapes):
            if isinstance(shape, HullShape):
                hull = HullShape(_shrunk(shape.points, margin))
                files[_hull_file(link, number)] = str(export_obj(shape_mesh(hull)))
    return files


def _shrunk(points: Floats, margin: float) -> Floats:
    """Corners of a hull whose faces lie deeper by a margin, or by nine tenths of its depth."""
    planes, middle = ConvexHull(points).equations, points.mean(axis=0)
    depth = -float((planes @ [*middle, 1]).max())
    planes[:, 3] += min(margin, 0.9 * depth)
    return np.asarray(HalfspaceIntersection(planes, middle).intersections)


def _hull_file(link: Link, number: int) -> str:
    return f"{link.name}-{number}.obj"


def _write_link(root: Element, link: Link) -> None:
    element = SubElement(root, "link", name=link.name)
    box = link.box
    inertial = SubElement(element, "inertial")
    _write_origin(inertial, box.center)
    SubElement(inertial, "mass", value=repr(link.mass))
    values = dict(zip(("ixx", "iyy", "izz"), map(repr, link.moments), strict=True))
    SubElement(inertial, "inertia", {**values, "ixy": "0", "ixz": "0", "iyz": "0"})
    for number, shape in enumerate(link.shapes):
        if isinstance(shape, Box):
            part = SubElement(element, "collision")
            _write_origin(part, shape.center)
            SubElement(SubElement(part, "geometry"), "box", size=_text(shape.size))
        else:
            part = SubElement(SubElement(element, "collision"), "geometry")
            SubElement(part, "mesh", filename=_hull_file(link, number))


def _write_origin(element: Element, origin: Vector, turn: Vector = (0.0, 0.0, 0.0)) -> None:
    angles = Rotation.from_rotvec(turn).as_euler("xyz")
    SubElement(element, "origin", xyz=_text(origin), rpy=_text(tuple(angles)))


def _text(values: Sequence[float]) -> str:
    return " ".join(repr(float(value)) for value in values)
