"""A simulated table, objects on it and a robot, whichever engine computes them."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple, Self

import numpy as np
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.geometry import RayCaster
from egad.sim.drives import LEFT, RIGHT
from egad.sim.model import Model, moved
from egad.sim.robot import PALM, TIP, Robot

GRAVITY = 9.81
DOWN = (0.0, 0.0, -GRAVITY)
WEIGHTLESS = (0.0, 0.0, 0.0)
TIME_STEP = 1 / 240  # seconds between control inputs; an engine may take shorter steps in between
HANGING_STEPS = 12  # time steps off the table before the load on a suction cup counts
CLOSING_SPEED = 0.1  # m/s, each finger
PARKED = 10.0  # metres from the table; unused objects are this far apart
REACH = 5.0  # metres; anything further away did not get there by physics
SUNK = 0.05
# m/s; a fall from 40 cm ends at 3. Only a penetration that is undone at once causes more than this.
MAX_SPEED = 10.0


# Owners of shapes; objects have the numbers from FIRST_OBJECT on
TABLE, LEFT_FINGER, RIGHT_FINGER, OTHERS, WALLS, FIRST_OBJECT = range(6)
FINGERS = {LEFT: LEFT_FINGER, RIGHT: RIGHT_FINGER}


class UnstableError(Exception):
    """The simulation went wrong: an object is nowhere, under the table, or shot away."""


class Pose(NamedTuple):
    """Position in metres (for an object, of its center of mass) and quaternion (x, y, z, w)."""

    position: Floats
    quaternion: Floats

    @classmethod
    def of(cls, numbers: Sequence[float]) -> Self:
        """Make a pose from three numbers of the position and four of the quaternion."""
        return cls(np.array(numbers[:3]), np.array(numbers[3:]))

    @property
    def matrix(self) -> Floats:
        """The (4, 4) transform from the frame of the body to the world."""
        matrix = np.eye(4)
        matrix[:3, :3] = Rotation.from_quat(self.quaternion).as_matrix()
        matrix[:3, 3] = self.position
        return matrix


class Forces(NamedTuple):
    """Normal forces of contacts, newtons, whatever their directions.

    On the objects: `left` and `right` of the fingers, `rest` of the robot, `support` of the table.
    `blocked`: of the table on the robot.
    """

    left: float
    right: float
    rest: float
    support: float
    blocked: float

    @classmethod
    def between(cls, sums: Floats, number: int | None) -> Self:
        """Those on one object or on all, from the sums between owners, the lower one first."""
        chosen = slice(FIRST_OBJECT, None) if number is None else [FIRST_OBJECT + number]
        on_objects, robot = sums[:, chosen].sum(axis=1), [LEFT_FINGER, RIGHT_FINGER, OTHERS]
        left, right, rest = on_objects[robot].tolist()
        return cls(left, right, rest, float(on_objects[TABLE]), float(sums[TABLE, robot].sum()))

    @property
    def hand(self) -> float:
        """Force of the whole robot on the objects."""
        return self.left + self.right + self.rest


class World(ABC):
    """A table at height 0, objects and perhaps a robot, simulated in a `with` block.

    The robot takes no part until it is placed somewhere, and neither do objects if there are
    several.

    Attributes:
        models: The objects; methods refer to them by number, starting from 0.
        robot: The robot that may grasp them.
        walls: Inner side of a square box without a floor, metres; None if there is no box.
        watch: Called after every time step, for films.
        attached: Number of the object that the suction cup of the robot holds; None if none.
        mass_factor: Masses of the objects / those of their models, from the next reset on.
        friction_factor: Friction of the robot / that of its pads, from the next reset on.
    """

    def __init__(
        self, models: Sequence[Model], robot: Robot | None = None, walls: float | None = None
    ) -> None:
        """Prepare a world of objects, a robot and walls, as the attributes say."""
        self.models = tuple(models)
        self.robot = robot
        self.walls = walls
        self.watch: Callable[[World], None] | None = None
        self.mass_factor = self.friction_factor = 1.0
        self.attached: int | None = None
        self._contact, self._hanging = 0.0, 0
        self._casters: dict[int, RayCaster] = {}

    @property
    def known_robot(self) -> Robot:
        """The robot; ValueError without one."""
        if self.robot is None:
            raise ValueError("there is no robot in this world")
        return self.robot

    @property
    def model(self) -> Model:
        """The first object."""
        return self.models[0]

    @abstractmethod
    def __enter__(self) -> Self:
        """Start the engine."""

    @abstractmethod
    def __exit__(self, *_: object) -> None:
        """Stop it."""

    @abstractmethod
    def reset(self) -> None:
        """Return to the initial state: a single object is above the table, several are parked."""

    @abstractmethod
    def set_gravity(self, acceleration: Sequence[float]) -> None:
        """Set the acceleration that acts from now on, (3,), m/s2."""

    @abstractmethod
    def place(
        self,
        pose: Pose,
        velocity: Sequence[float] = (0.0, 0.0, 0.0),
        turning: Sequence[float] = (0.0, 0.0, 0.0),
        number: int = 0,
    ) -> None:
        """Place an object, at rest or with a velocity (m/s) and an angular velocity (rad/s)."""

    @abstractmethod
    def remove_walls(self) -> None:
        """Remove the walls until the world is reset."""

    @abstractmethod
    def put_robot(self, base: Pose, joints: Sequence[float], opening: float) -> None:
        """Place the robot, at rest, with its joints held where they are."""

    @abstractmethod
    def drive(self, joints: Sequence[float], speeds: Sequence[float]) -> None:
        """Command the arm to reach positions at these speeds after the next step."""

    @abstractmethod
    def close_fingers(self) -> None:
        """Close the moving fingers at `CLOSING_SPEED`, or press with their force."""

    @abstractmethod
    def arm_joints(self) -> Floats:
        """Positions of the arm's joints, metres or radians."""

    @abstractmethod
    def fingers(self) -> tuple[Floats, Floats]:
        """Distances of the left and right finger from the middle (m), and their speeds (m/s)."""

    @abstractmethod
    def forces(self, number: int | None = None) -> Forces:
        """Normal forces of contacts after the last step, of one object or of all."""

    @abstractmethod
    def link_poses(self) -> list[Pose]:
        """Poses of the links of the robot; none before it is placed."""

    @abstractmethod
    def speeds(self) -> tuple[float, float]:
        """Highest speed of a center of mass in m/s, and highest angular speed in rad/s."""

    @abstractmethod
    def _numbers(self, number: int) -> tuple[Sequence[float], Sequence[float]]:
        """Position and quaternion (x, y, z, w) of an object."""

    @abstractmethod
    def _advance(self) -> float:
        """Take a time step, and return the speed of the fastest object, m/s."""

    @abstractmethod
    def _pin(self, pose: Pose, number: int) -> None:
        """Hold an object at a pose."""

    @abstractmethod
    def _unpin(self, number: int) -> None:
        """Release the object."""

    @abstractmethod
    def _attach(self, pose: Floats, number: int) -> None:
        """Hold an object at its current pose, (4, 4), in the frame of the palm."""

    @abstractmethod
    def _detach(self, number: int) -> None:
        """Release the object."""

    @abstractmethod
    def _pull(self, number: int) -> Floats:
        """Mean force and torque of the palm on an object that it holds, in the world, (2, 3)."""

    def attach(self, number: int, depth: float = 0.0) -> None:
        """Let the suction cup of the robot hold an object where it is now.

        It is held as long as the cup resists its load (`Drive.resists`) about the middle of the
        ring, whose depth in the frame of the cup is given, metres. A real cup gives way, this one
        is rigid: the load counts once the object has been off the table for 0.05 s.
        """
        self._contact, self._hanging = depth, 0
        palm = self._link_pose(PALM)
        self._attach(np.linalg.inv(palm) @ self.pose(number).matrix, number)
        self.attached = number

    def detach(self) -> None:
        """Release the object that the suction cup holds."""
        if self.attached is not None:
            self._detach(self.attached)
            self.attached = None

    def load(self) -> Floats:
        """Force and torque of an object on the cup that holds it, in its frame, (6,), N and N m."""
        number = self.attached
        if number is None:
            return np.zeros(6)
        force, torque = self._pull(number)
        tip = self._link_pose(TIP)
        lever = self.pose(number).position - tip[:3, 3] - self._contact * tip[:3, 2]
        both = np.stack([force, torque + np.cross(lever, force)])
        load: Floats = -(both @ tip[:3, :3]).ravel()
        return load

    def caster(self, number: int) -> RayCaster:
        """Ray caster of the surface of an object, in its own frame."""
        if number not in self._casters:
            self._casters[number] = RayCaster(self.models[number].mesh)
        return self._casters[number]

    def cup_pose(self) -> Floats:
        """The frame of the suction cup (`egad.grasps.suction.seal`) in the world, (4, 4)."""
        return self._link_pose(TIP)

    def _link_pose(self, name: str) -> Floats:
        links = self.robot.links if self.robot else ()
        number = [link.name for link in links].index(name)
        return self.link_poses()[number].matrix

    def _check_load(self, number: int) -> None:
        """Release an object that the cup cannot hold, unless it still stands on the table."""
        self._hanging = 0 if self.forces(number).support > 0 else self._hanging + 1
        resists = self.known_robot.drive.resists
        if self._hanging > HANGING_STEPS and not resists(self.load(), self.friction_factor):
            self.detach()

    @contextmanager
    def pinned(self) -> Iterator[None]:
        """Hold the first object where it is, for the duration of the `with` block."""
        self._pin(self.pose(), 0)
        try:
            yield
        finally:
            self._unpin(0)

    def _place_objects(self) -> None:
        """Put a single object above the table, and park several."""
        if len(self.models) == 1:
            height = float(self.model.mesh.scale)
            self.place(Pose.of((0.0, 0.0, height, 0.0, 0.0, 0.0, 1.0)))
            return
        for number in range(len(self.models)):
            self.park(number)

    def park(self, number: int) -> None:
        """Move an object out of the way, until it is placed again."""
        far = Pose(np.array([PARKED * (number + 1), 0.0, PARKED]), np.array([0.0, 0.0, 0.0, 1.0]))
        self.place(far, number=number)
        self._pin(far, number)

    def present(self) -> list[int]:
        """Numbers of the objects that are not parked."""
        numbers = range(len(self.models))
        return [number for number in numbers if self._numbers(number)[0][2] < PARKED / 2]

    def pose(self, number: int = 0) -> Pose:
        """The current pose; UnstableError if it is not finite, out of reach or under the table."""
        position, quaternion = map(np.array, self._numbers(number))
        finite = np.isfinite(position).all() and np.isfinite(quaternion).all()
        if not finite or np.abs(position).max() > REACH or position[2] < -SUNK:
            raise UnstableError(f"an object is at {position}")
        return Pose(position, quaternion)

    def vertices(self, number: int = 0) -> Floats:
        """The vertices of an object's surface at its current pose, (n, 3)."""
        return moved(self.models[number].mesh.vertices, self.pose(number).matrix)

    def step(self, steps: int = 1) -> None:
        """Advance by steps of 1/240 s; UnstableError if an object is faster than it can be."""
        for _ in range(steps):
            if not self._advance() < MAX_SPEED:  # also raises for NaN
                raise UnstableError("an object was flung away")
            if self.attached is not None:
                self._check_load(self.attached)
            if self.watch is not None:
                self.watch(self)
