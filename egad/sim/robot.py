"""A hand on an arm as links with their shapes, and joints; the walls of a box."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.grippers import Gripper
from egad.sim.drives import Drive, Follower

Vector = tuple[float, float, float]
WALL_HEIGHT, WALL_THICKNESS = 0.4, 0.05  # metres


@dataclass(frozen=True)
class Box:
    """A box whose sides are parallel to the axes of its link: lengths and center, metres."""

    size: Vector
    center: Vector


@dataclass(frozen=True, eq=False)
class HullShape:
    """The convex hull of points, (n, 3) in the frame of the link, metres."""

    points: Floats


def corners(shape: Box | HullShape) -> Floats:
    """Points that a shape is the hull of, or two opposite corners of a box."""
    if isinstance(shape, HullShape):
        return shape.points
    half = np.array(shape.size) / 2
    return np.array([shape.center - half, shape.center + half])


def vector(values: Floats) -> Vector:
    """Three numbers as a tuple of floats."""
    x, y, z = map(float, values)
    return x, y, z


def shape_mesh(shape: Box | HullShape) -> trimesh.Trimesh:
    """A shape in the frame of its link, metres."""
    if isinstance(shape, HullShape):
        hull: trimesh.Trimesh = trimesh.convex.convex_hull(shape.points)
        return hull
    mesh: trimesh.Trimesh = trimesh.creation.box(shape.size)
    mesh.apply_translation(shape.center)
    return mesh


def wall_boxes(inside: float) -> list[Box]:
    """Four boxes around a square of the table with the given side, metres."""
    along, off = inside + 2 * WALL_THICKNESS, (inside + WALL_THICKNESS) / 2
    across = [
        Box((WALL_THICKNESS, along, WALL_HEIGHT), (x, 0.0, WALL_HEIGHT / 2)) for x in (-off, off)
    ]
    return across + [
        Box((along, WALL_THICKNESS, WALL_HEIGHT), (0.0, y, WALL_HEIGHT / 2)) for y in (-off, off)
    ]


Motion = Callable[[float], Floats]

PALM, TIP = "palm", "tip"
EFFORT = 1000.0  # N or N m that no joint exceeds


@dataclass(frozen=True)
class Link:
    """A rigid body of a robot; its inertia is that of a uniform box around its shapes."""

    name: str  # name of the link
    mass: float = 0.0  # kilograms
    shapes: tuple[Box | HullShape, ...] = ()  # shapes that collide
    soft: tuple[HullShape, ...] = ()  # shapes that are only seen, such as a suction cup

    @property
    def box(self) -> Box:
        """The box around its shapes; of size 0 if there are none."""
        if len(self.shapes) == 1 and isinstance(self.shapes[0], Box):
            return self.shapes[0]
        ends = [corners(shape) for shape in self.shapes] or [np.zeros((1, 3))]
        low = np.min([each.min(axis=0) for each in ends], axis=0)
        high = np.max([each.max(axis=0) for each in ends], axis=0)
        return Box(vector(high - low), vector((low + high) / 2))

    @property
    def moments(self) -> Vector:
        """Principal moments of inertia, kg m2."""
        squares = [side**2 for side in self.box.size]
        x, y, z = (self.mass / 12 * (sum(squares) - square) for square in squares)
        return x, y, z


@dataclass(frozen=True)
class Joint:
    """How a link is attached to another one."""

    child: str  # name of the link, and of the joint
    parent: str  # name of the link that carries it
    kind: Literal["prismatic", "revolute", "fixed"] = "fixed"  # how it moves
    # origin of the child's frame in that of the parent at position 0, metres
    origin: Vector = (0.0, 0.0, 0.0)
    turn: Vector = (0.0, 0.0, 0.0)  # rotation of the child's frame, a rotation vector, radians
    axis: Vector = (0.0, 0.0, 1.0)  # axis that it moves along or about, in the frame of the child
    limits: tuple[float, float] = (0.0, 0.0)  # limits of the motion, metres or radians


@dataclass(frozen=True)
class Robot:
    """An arm, and at its end a palm with two fingers that mirror each other, one jaw, or a cup.

    The joints LEFT and RIGHT move the fingers themselves, or carriages without a body that the
    joints of a linkage follow. A fixed jaw is on the right, at negative x. TIP is between the
    fingertips, or the middle of the ring of a suction cup.
    """

    gripper: Gripper  # force and pads of the fingers
    links: tuple[Link, ...]  # the root first
    joints: tuple[Joint, ...]  # one for each link except the root, in the same order
    # force or torque of each joint of the arm, by its name, N or N m
    strength: dict[str, float] = field(hash=False)
    # LEFT or RIGHT for each link of a finger, by its name
    sides: dict[str, str] = field(hash=False)
    drive: Drive = field(compare=False)  # what closes the hand
    # joints that follow those of the fingers
    followers: tuple[Follower, ...] = field(default=(), compare=False)
    # openings, ascending, and positions of the pads along the approach, metres; the fingertips are
    # at TIP when the pads are at 0
    path: tuple[Floats, Floats] | None = field(default=None, compare=False)

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
