"""A hand on an arm as links and joints, and as URDF."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import trimesh
from scipy.spatial import ConvexHull, HalfspaceIntersection
from scipy.spatial.transform import Rotation
from trimesh.exchange.obj import export_obj

from egad._util.arrays import Floats
from egad.grippers import Gripper

Vector = tuple[float, float, float]
Motion = Callable[[float], Floats]

PALM, LEFT, RIGHT, TIP = "palm", "left", "right", "tip"
DEGREE = 4  # of the polynomials between joints, as in MuJoCo


@dataclass(frozen=True)
class Box:
    """A box whose sides are parallel to the axes of its link: lengths and center, metres."""

    size: Vector
    center: Vector


@dataclass(frozen=True, eq=False)
class HullShape:
    """The convex hull of points, (n, 3) in the frame of the link, metres."""

    points: Floats


@dataclass(frozen=True)
class Link:
    """A rigid body of a robot; its inertia is that of a uniform box around its shapes.

    Attributes:
        name: Name of the link.
        mass: Kilograms.
        shapes: Shapes that collide.
        soft: Shapes that are only seen, such as a suction cup.
    """

    name: str
    mass: float = 0.0
    shapes: tuple[Box | HullShape, ...] = ()
    soft: tuple[HullShape, ...] = ()

    @property
    def box(self) -> Box:
        """The box around its shapes; of size 0 if there are none."""
        if len(self.shapes) == 1 and isinstance(self.shapes[0], Box):
            return self.shapes[0]
        corners = [_corners(shape) for shape in self.shapes] or [np.zeros((1, 3))]
        low = np.min([each.min(axis=0) for each in corners], axis=0)
        high = np.max([each.max(axis=0) for each in corners], axis=0)
        return Box(_vector(high - low), _vector((low + high) / 2))


@dataclass(frozen=True)
class Joint:
    """How a link is attached to another one.

    Attributes:
        child: Name of the link, and of the joint.
        parent: Name of the link that carries it.
        kind: How it moves.
        origin: Origin of the child's frame in that of the parent at position 0, metres.
        turn: Rotation of the child's frame, a rotation vector, radians.
        axis: Axis that it moves along or about, in the frame of the child.
        limits: Limits of the motion, metres or radians.
    """

    child: str
    parent: str
    kind: Literal["prismatic", "revolute", "fixed"] = "fixed"
    origin: Vector = (0.0, 0.0, 0.0)
    turn: Vector = (0.0, 0.0, 0.0)
    axis: Vector = (0.0, 0.0, 1.0)
    limits: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Follower:
    """A joint of a linkage, whose position follows from that of a finger.

    Attributes:
        joint: Its name.
        side: The finger.
        distances: (k,) distances of that finger's pad from the middle, ascending, metres.
        positions: (k,) positions of the joint, metres or radians.
    """

    joint: str
    side: str
    distances: Floats
    positions: Floats

    def at(self, distance: float) -> float:
        """Its position when the pad is this far from the middle."""
        return float(np.interp(distance, self.distances, self.positions))

    def slope(self, distance: float) -> float:
        """Derivative of its position with respect to the distance of the pad."""
        step = float(np.diff(self.distances).mean())
        return (self.at(distance + step) - self.at(distance - step)) / (
            min(distance + step, float(self.distances[-1]))
            - max(distance - step, float(self.distances[0]))
        )

    def polynomial(self) -> Floats:
        """Coefficients of its position as a polynomial of the distance, constant term first."""
        fitted = np.polynomial.Polynomial.fit(self.distances, self.positions, DEGREE).convert()
        return np.pad(fitted.coef, (0, DEGREE + 1 - len(fitted.coef)))


@dataclass(frozen=True, eq=False)
class JawJoint:
    """The joint of a hand with one moving jaw.

    Attributes:
        joint: Its name.
        openings: (k,) distances of the pads, ascending, metres.
        positions: (k,) its positions there, metres or radians.
        lever: Its torque per newton between the pads, metres; 1 if it slides.
    """

    joint: str
    openings: Floats
    positions: Floats
    lever: float

    @property
    def closing(self) -> float:
        """How far it moves per metre that the pad moves inwards; the sign is the direction."""
        return float(np.sign(self.positions[0] - self.positions[-1])) / self.lever

    def at(self, opening: float) -> float:
        """Its position at an opening."""
        return float(np.interp(opening, self.openings, self.positions))

    def opening(self, position: float, speed: float) -> tuple[float, float]:
        """The opening at a position, metres, and how fast it grows at a speed, m/s."""
        order = slice(None, None, 1 if self.positions[-1] > self.positions[0] else -1)
        positions, openings = self.positions[order], self.openings[order]
        slopes = np.gradient(openings, positions)
        return (
            float(np.interp(position, positions, openings)),
            speed * float(np.interp(position, positions, slopes)),
        )


@dataclass(frozen=True)
class Robot:
    """An arm, and at its end a palm with two fingers that mirror each other, one jaw, or a cup.

    The positions of the joints LEFT and RIGHT are the distances of the pads from the middle. These
    joints move the fingers themselves, or carriages without a body that the joints of a linkage
    follow. A hand with one moving jaw has the joint of this jaw instead; the fixed jaw is on the
    right, at negative x. TIP is the middle of the ring of a suction cup.

    Attributes:
        gripper: Force and pads of the fingers.
        links: The root first.
        joints: One for each link except the root, in the same order.
        strength: Force or torque of each joint of the arm, by its name, N or N m.
        sides: LEFT or RIGHT for each link of a finger, by its name.
        followers: Joints that follow those of the fingers.
        path: Openings, ascending, and positions of the pads along the approach, metres; the
            fingertips are at TIP when the pads are at 0.
        jaw: The joint of a hand with one moving jaw.
    """

    gripper: Gripper
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    strength: dict[str, float] = field(hash=False)
    sides: dict[str, str] = field(hash=False)
    followers: tuple[Follower, ...] = field(default=(), compare=False)
    path: tuple[Floats, Floats] | None = field(default=None, compare=False)
    jaw: JawJoint | None = field(default=None, compare=False)

    def aside(self, opening: float) -> float:
        """How far the middle between the pads is beside TIP at an opening, along x, metres."""
        return 0.0 if self.jaw is None else (opening - float(self.jaw.openings[0])) / 2

    @property
    def fingers(self) -> tuple[str, ...]:
        """Names of the joints that close the hand; none for a suction cup."""
        if self.gripper.cup is not None:
            return ()
        return (LEFT, RIGHT) if self.jaw is None else (self.jaw.joint,)

    @property
    def finger_strength(self) -> float:
        """Force or torque of each joint in `fingers`, N or N m."""
        return self.gripper.force * (1.0 if self.jaw is None else self.jaw.lever)

    @property
    def closing(self) -> float:
        """How far each joint in `fingers` moves per metre that its pad moves inwards."""
        return -1.0 if self.jaw is None else self.jaw.closing

    def finger_position(self, opening: float) -> float:
        """Position of each joint in `fingers` at an opening."""
        return opening / 2 if self.jaw is None else self.jaw.at(opening)

    def pads(self, positions: Floats, speeds: Floats) -> tuple[Floats, Floats]:
        """Distances of both pads from their middle, and their speeds: (2,) each, m and m/s."""
        if self.jaw is None:
            return positions, speeds
        opening, speed = self.jaw.opening(float(positions[0]), float(speeds[0]))
        return np.full(2, opening / 2), np.full(2, speed / 2)

    def reach(self, opening: float) -> float:
        """How far beyond TIP the fingertips are at an opening, along the approach, metres."""
        return 0.0 if self.path is None else float(np.interp(opening, *self.path))

    @property
    def arm(self) -> tuple[str, ...]:
        """Names of the joints that move the palm, in the order of their positions."""
        return tuple(self.strength)

    def tip_poses(self, positions: Sequence[float]) -> list[Floats]:
        """Frames of the arm's joints, then of the tip, in that of the root, (4, 4) each."""
        values, poses = iter(positions), []
        pose = np.eye(4)
        for moves, motion in self._chain:
            pose = pose @ motion(next(values) if moves else 0.0)
            if moves:
                poses.append(pose)
        return [*poses, pose]

    @cached_property
    def _chain(self) -> list[tuple[bool, Motion]]:
        """The joints from the root to the tip: whether the arm moves them, and how."""
        by_child = {joint.child: joint for joint in self.joints}
        chain = [by_child[TIP]]
        while chain[0].parent in by_child:
            chain.insert(0, by_child[chain[0].parent])
        return [(joint.child in self.strength, _motion(joint)) for joint in chain]


def to_urdf(robot: Robot, *, hulls: bool = True) -> str:
    """The robot as URDF, with or without hulls, which are meshes in the files of `hull_files`."""
    root = Element("robot", name="robot")
    for link in robot.links:
        _write_link(root, link, hulls)
    for joint in robot.joints:
        element = SubElement(root, "joint", name=joint.child, type=joint.kind)
        _write_origin(element, joint.origin, joint.turn)
        SubElement(element, "parent", link=joint.parent)
        SubElement(element, "child", link=joint.child)
        if joint.kind != "fixed":
            SubElement(element, "axis", xyz=_text(joint.axis))
            low, high = map(repr, joint.limits)
            SubElement(element, "limit", lower=low, upper=high, effort="1000", velocity="10")
    ElementTree.indent(root)  # PyBullet cuts lines of more than 8192 characters
    return ElementTree.tostring(root, encoding="unicode")


def _motion(joint: Joint) -> Motion:
    """The (4, 4) transform from the child's frame to the parent's, as a function of position."""
    fixed = np.eye(4)
    fixed[:3, :3] = Rotation.from_rotvec(joint.turn).as_matrix()
    fixed[:3, 3] = joint.origin
    x, y, z = joint.axis
    shift, cross = np.zeros((2, 4, 4))
    shift[:3, 3] = fixed[:3, :3] @ joint.axis
    cross[:3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    first, second = fixed @ cross, fixed @ cross @ cross
    if joint.kind == "prismatic":
        return lambda value: fixed + value * shift
    # Rodrigues' formula
    return lambda value: fixed + math.sin(value) * first + (1 - math.cos(value)) * second


def shape_mesh(shape: Box | HullShape) -> trimesh.Trimesh:
    """A shape in the frame of its link, metres."""
    if isinstance(shape, HullShape):
        hull: trimesh.Trimesh = trimesh.convex.convex_hull(shape.points)
        return hull
    mesh: trimesh.Trimesh = trimesh.creation.box(shape.size)
    mesh.apply_translation(shape.center)
    return mesh


def hull_files(robot: Robot, margin: float = 0.0) -> dict[str, str]:
    """The hulls of a robot as OBJ files, by the name that its URDF gives them.

    Each is shrunk by a margin, metres, on all sides, if it is thick enough.
    """
    files = {}
    for link in robot.links:
        for number, shape in enumerate(link.shapes):
            if isinstance(shape, HullShape):
                hull = HullShape(_shrunk(shape.points, margin))
                files[_hull_file(link, number)] = str(export_obj(shape_mesh(hull)))
    return files


def _shrunk(points: Floats, margin: float) -> Floats:
    planes, middle = ConvexHull(points).equations, points.mean(axis=0)
    planes[:, 3] += margin
    if (planes @ [*middle, 1] > -margin).any():
        return points
    return np.asarray(HalfspaceIntersection(planes, middle).intersections)


def _hull_file(link: Link, number: int) -> str:
    return f"{link.name}-{number}.obj"


def _write_link(root: Element, link: Link, hulls: bool) -> None:
    element = SubElement(root, "link", name=link.name)
    box = link.box
    inertial = SubElement(element, "inertial")
    _write_origin(inertial, box.center)
    SubElement(inertial, "mass", value=repr(link.mass))
    squares = [side**2 for side in box.size]
    moments = [repr(link.mass / 12 * (sum(squares) - square)) for square in squares]
    values = dict(zip(("ixx", "iyy", "izz"), moments, strict=True))
    SubElement(inertial, "inertia", {**values, "ixy": "0", "ixz": "0", "iyz": "0"})
    for number, shape in enumerate(link.shapes):
        if isinstance(shape, Box):
            part = SubElement(element, "collision")
            _write_origin(part, shape.center)
            SubElement(SubElement(part, "geometry"), "box", size=_text(shape.size))
        elif hulls:
            part = SubElement(SubElement(element, "collision"), "geometry")
            SubElement(part, "mesh", filename=_hull_file(link, number))


def _corners(shape: Box | HullShape) -> Floats:
    if isinstance(shape, HullShape):
        return shape.points
    half = np.array(shape.size) / 2
    return np.array([shape.center - half, shape.center + half])


def _vector(values: Floats) -> Vector:
    x, y, z = map(float, values)
    return x, y, z


def _write_origin(element: Element, origin: Vector, turn: Vector = (0.0, 0.0, 0.0)) -> None:
    angles = Rotation.from_rotvec(turn).as_euler("xyz")
    SubElement(element, "origin", xyz=_text(origin), rpy=_text(tuple(angles)))


def _text(values: Sequence[float]) -> str:
    return " ".join(repr(float(value)) for value in values)
