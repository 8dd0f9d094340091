"""Files of a hand with fingertips: URDF and MJCF with convex shapes, and the tips to print."""

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import mujoco
import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad._util.files import write_text
from egad.bench.tips.base import Base, pose_of
from egad.bench.tips.solids import Tip
from egad.grippers import HandLink
from egad.io import write_stl_mm

SHAPES = "shapes"  # folder of the shapes of links
INERTIA = 1e-3  # kg m2 per kilogram, as a hand of some centimetres has
PLA = 1240.0  # kg/m3
MIN_MASS = 1e-3  # kilograms
OPTIONS = dict.fromkeys(("strippath", "fusestatic", "discardvisual"), "false")


def write_hand(base: Base, tips: Sequence[Tip], folder: Path) -> Path:
    """Write a hand with tips of PLA, without its arm: hand.urdf, whose path it is, and hand.xml."""
    (folder / SHAPES).mkdir(parents=True, exist_ok=True)
    root = Element("robot", name="hand")
    SubElement(SubElement(root, "mujoco"), "compiler", OPTIONS)
    for number, link in enumerate(base.model.links):
        own = [tip for tip in tips if tip.link == number]
        root.append(_link(link, own, folder))
    for number in range(1, len(base.model.links)):
        root.append(_joint(base, number))
    ElementTree.indent(root)
    path = folder / "hand.urdf"
    write_text(path, ElementTree.tostring(root, encoding="unicode") + "\n")
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compile()
    write_text(folder / "hand.xml", spec.to_xml())
    return path


def _link(link: HandLink, tips: Sequence[Tip], folder: Path) -> Element:
    """A link with its convex shapes and those of its tips, whose plastic adds to its mass."""
    element = Element("link", name=link.name)
    mass = max(link.mass + PLA * sum(float(tip.added.volume) for tip in tips), MIN_MASS)
    inertial = SubElement(element, "inertial")
    SubElement(inertial, "mass", value=f"{mass:.6g}")
    moments = {f"i{axis}{axis}": f"{INERTIA * mass:.6g}" for axis in "xyz"}
    SubElement(inertial, "inertia", moments | {"ixy": "0", "ixz": "0", "iyz": "0"})
    shapes = [*link.shapes, *(piece for tip in tips for piece in tip.pieces)]
    for number, points in enumerate(shapes):
        name = f"{SHAPES}/{link.name}-{number}.stl"
        write_stl_mm(trimesh.convex.convex_hull(points - _anchor(link)), folder / name)
        for kind in ("visual", "collision"):
            geometry = SubElement(SubElement(element, kind), "geometry")
            SubElement(geometry, "mesh", filename=name, scale="0.001 0.001 0.001")
    return element


def _joint(base: Base, number: int) -> Element:
    """The joint of a link: as it moves in the original, or fixed."""
    link = base.model.links[number]
    carrier = max(link.carrier, 0)
    opening = float(base.model.openings[0])
    behind, pose = (pose_of(base.model, each, opening) for each in (carrier, number))
    pose = np.linalg.inv(behind) @ pose
    name = link.joint.name if link.joint else f"{link.name}_mount"
    position = base.model.joint_positions(opening).get(name, 0.0)
    pose = pose @ np.linalg.inv(_motion(link, position))
    pose[:3, 3] += pose[:3, :3] @ _anchor(link) - _anchor(base.model.links[carrier])
    element = Element("joint", name=name, type=link.joint.kind if link.joint else "fixed")
    angles = Rotation.from_matrix(pose[:3, :3]).as_euler("xyz")
    SubElement(element, "origin", xyz=_text(pose[:3, 3]), rpy=_text(angles))
    SubElement(element, "parent", link=base.model.links[carrier].name)
    SubElement(element, "child", link=link.name)
    if link.joint is not None:
        SubElement(element, "axis", xyz=_text(link.joint.axis))
        low, high = (f"{end:.9g}" for end in base.limits[link.joint.name])
        SubElement(element, "limit", lower=low, upper=high, effort="10", velocity="10")
        row = base.model.joints.index(link.joint.name)
        if row >= base.model.n_driven:
            first, own = base.model.positions[:, 0], base.model.positions[:, row]
            slope = float((own[-1] - own[0]) / (first[-1] - first[0]))
            mimic = SubElement(element, "mimic", joint=base.model.joints[0])
            mimic.set("multiplier", f"{slope:.9g}")
            mimic.set("offset", f"{own[0] - slope * first[0]:.9g}")
    return element


def _motion(link: HandLink, position: float) -> Floats:
    """What the joint of a link does to it, in its own frame, (4, 4)."""
    if link.joint is None:
        return np.eye(4)
    if link.joint.kind == "prismatic":
        return np.asarray(trimesh.transformations.translation_matrix(position * link.joint.axis))
    axis, anchor = link.joint.axis, link.joint.anchor
    return np.asarray(trimesh.transformations.rotation_matrix(position, axis, anchor))


def _anchor(link: HandLink) -> Floats:
    """Where the origin of a link is in the file: on the axis of its joint, as URDF wants it."""
    if link.joint is None or link.joint.kind == "prismatic":
        return np.zeros(3)
    return link.joint.anchor


def _text(values: Floats) -> str:
    """Numbers of an attribute; 0 has no sign."""
    return " ".join(f"{value + 0.0:.9g}" for value in np.round(values, 12))
