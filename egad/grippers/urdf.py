"""URDF files, reduced to what a hand needs and MuJoCo accepts."""

import logging
import math
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement, TreeBuilder
from xml.parsers import expat

from egad.errors import UserError

log = logging.getLogger(__name__)

JOINT_ELEMENTS = ("origin", "parent", "child", "axis", "limit", "mimic")
SHAPES = ("box", "cylinder", "sphere", "capsule", "mesh")
JOINTS = ("fixed", "revolute", "continuous", "prismatic", "planar", "floating")
NUMBERS = {"lower", "upper", "multiplier", "offset", "xyz", "rpy", "size", "scale", "value"}
NUMBERS |= {"radius", "length"}
INERTIA = 1e-3  # kg m2 per kilogram; the motion of a hand does not depend on it


def read_urdf(path: Path) -> str | None:
    """The links and joints of a URDF file, as text that MuJoCo reads; None if it is MJCF.

    Whatever is only seen, driven, measured or simulated is left out. The first of several elements
    counts, as in ROS; a floating joint is treated as fixed, to what carries the hand.
    """
    root = _root(path.read_bytes())
    if root is None or root.tag == "mujoco":
        return None
    if root.tag != "robot":
        raise UserError(f"it is not URDF or MJCF: its root element is <{root.tag}>")
    if any(_is_xacro(each) for each in root.iter()):
        name = path.name.removesuffix(".xacro").removesuffix(".urdf") + ".urdf"
        if name == path.name:  # a shell empties its output before xacro reads its input
            name = f"expanded_{name}"
        raise UserError(
            f"it is a xacro file; expand it with `xacro {path.name} > {name}` of ROS, or "
            f"without ROS: `pip install xacrodoc`, then `xacrodoc {path.name} -o {name}`"
        )
    links = _by_name([_link(each, path) for each in root.findall("link")])
    joints = _by_name([_joint(each, path) for each in root.findall("joint")])
    _check(links, joints)
    clean = Element("robot", name=root.get("name", ""))
    clean.extend([*root.findall("mujoco")[:1], *links.values(), *joints.values()])
    return ElementTree.tostring(clean, encoding="unicode")


def without_faults(path: Path) -> str | None:
    """MJCF without repeated assets and attributes of defaults, as some write; None if in order."""
    root, faulty = _root(path.read_bytes()), False
    if root is None:
        return None
    assets: dict[tuple[str, str], dict[str, str]] = {}
    for element in [*root.iter()]:
        for child in list(element) if element.tag == "asset" else []:
            name = child.get("name") or Path(child.get("file", "")).stem
            if name and assets.setdefault((child.tag, name), child.attrib) is not child.attrib:
                if assets[child.tag, name] != child.attrib:
                    raise UserError(f"it has two different assets <{child.tag}> named {name}")
                element.remove(child)
                faulty = True
        if element.tag == "default" and set(element.attrib) - {"class"}:
            element.attrib = {key: element.attrib[key] for key in element.attrib if key == "class"}
            faulty = True
        if element.tag == "include":
            element.set("file", str(path.resolve().parent / element.get("file", "")))
    return ElementTree.tostring(root, encoding="unicode") if faulty else None


def _root(data: bytes) -> Element | None:
    """The outermost element; None if it is not XML. Prefixes of names need not be declared."""
    builder, parser = TreeBuilder(), expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = builder.start, builder.end
    try:
        parser.Parse(data, True)
    except expat.ExpatError:  # MuJoCo allows more, and says what is wrong
        return None
    return builder.close()


def _is_xacro(element: Element) -> bool:
    """Whether an element or one of its attributes is to be expanded."""
    texts = element.attrib.values()
    return element.tag.startswith("xacro:") or any("${" in each or "$(" in each for each in texts)


def _link(given: Element, path: Path) -> Element:
    """The mass and the collision shapes of a link."""
    link = Element("link", name=_name(given))
    mass = given.find("inertial/mass")
    if mass is not None:
        link.append(_inertial(mass, link))
    for shape in given.findall("collision"):
        kinds = shape.findall("geometry/*")
        if not kinds:
            log.warning("%s: a collision shape of the link %s is empty", path, link.get("name"))
            continue
        if kinds[0].tag not in SHAPES:
            raise UserError(
                f"a collision shape of the link {link.get('name')} is a <{kinds[0].tag}>; "
                f"allowed: {', '.join(SHAPES)}"
            )
        collision = SubElement(link, "collision")
        collision.extend(shape.findall("origin")[:1])
        SubElement(collision, "geometry").append(kinds[0])
    _check_numbers(link)
    return link


def _inertial(mass: Element, link: Element) -> Element:
    """The mass of a link with some moments of inertia that are possible."""
    value = _numbers(mass, "value", link)[0]
    if not 0 <= value < math.inf:
        raise UserError(f"the link {link.get('name')} has a mass of {value:g} kg")
    moments = {f"i{axes}": "0" for axes in ("xy", "xz", "yz")}
    moments |= {f"i{axis}{axis}": repr(value * INERTIA) for axis in "xyz"}
    inertial = Element("inertial")
    inertial.append(mass)
    SubElement(inertial, "inertia", moments)
    return inertial


def _joint(given: Element, path: Path) -> Element:
    """How a joint moves."""
    name, kind = _name(given), given.get("type")
    if kind not in JOINTS:
        raise UserError(f"the joint {name} has the type {kind!r}; allowed: {', '.join(JOINTS)}")
    joint = Element("joint", name=name, type="fixed" if kind == "floating" else kind)
    for tag in JOINT_ELEMENTS:
        found = given.findall(tag)
        if any(each.attrib != found[0].attrib for each in found):
            log.warning(
                "%s: the joint %s has %d <%s> elements; only the first is used",
                path,
                name,
                len(found),
                tag,
            )
        joint.extend(found[:1])
    _check_numbers(joint)
    return joint


def _check_numbers(part: Element) -> None:
    """Raise UserError if a link or joint has something else where a number is expected."""
    for element in part.iter():
        for key in sorted(NUMBERS & set(element.attrib)):
            _numbers(element, key, part)


def _numbers(element: Element, key: str, part: Element) -> list[float]:
    """The numbers in an element of a link or joint."""
    text = element.get(key, "")
    try:
        found = [float(each) for each in text.split()]
    except ValueError:
        found = []
    if not found or any(math.isnan(each) for each in found):
        raise UserError(
            f"the {part.tag} {part.get('name')} has {key}={text!r} in <{element.tag}>; "
            "allowed: numbers like 0.04"
        )
    return found


def _name(element: Element) -> str:
    name = element.get("name", "")
    if not name:
        raise UserError(f"one of its <{element.tag}> elements has no name")
    return name


def _by_name(elements: list[Element]) -> dict[str, Element]:
    """Links or joints by their names; the same one may occur twice."""
    found: dict[str, Element] = {}
    for element in elements:
        name = element.get("name", "")
        if name in found and ElementTree.tostring(found[name]) != ElementTree.tostring(element):
            raise UserError(f"it has two different {element.tag}s named {name}")
        found[name] = element
    return found


def _check(links: Mapping[str, Element], joints: Mapping[str, Element]) -> None:
    """Raise UserError if a joint names a missing link or joint, or a link hangs on two joints."""
    carriers: dict[str, str] = {}
    for name, joint in joints.items():
        link = ""
        for tag in ("parent", "child"):
            found = joint.find(tag)
            link = "" if found is None else found.get("link", "")
            if link not in links:
                raise UserError(
                    f"the {tag} of the joint {name} is {link!r}, a link that is not in the file"
                )
        if link in carriers:
            raise UserError(
                f"the link {link} is the child of two joints, {carriers[link]} and {name}"
            )
        carriers[link] = name
        mimic = joint.find("mimic")
        if mimic is not None and mimic.get("joint") not in joints:
            leader = mimic.get("joint")
            raise UserError(f"the joint {name} mimics {leader!r}, a joint that is not in the file")
