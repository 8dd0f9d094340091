"""A simulated table and an object on it, in PyBullet without a window."""

import functools
import math
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
import pybullet
from numpy.typing import NDArray

from egad.sim.model import Model

Floats = NDArray[np.float64]

GRAVITY = 9.81
TIME_STEP = 1 / 240
# With 50 iterations a 40 mm cube of 50 g is pressed into the fingers by 0.6 mm at 70 N and by 6 mm
# at 100 N; 100 do for it, and 150 leave something for thinner objects.
SOLVER_ITERATIONS = 150
# The engine multiplies the friction of two bodies; with 1 for the object, the other one decides.
OBJECT_FRICTION = 1.0
TABLE_FRICTION = 0.5  # plastic on wood or paper
# Without it a ball rolls or spins for ever. As a length: where the ground pushes ahead of it.
TABLE_ROLLING = 0.001
# The engine's 1 mm is added all around convex parts: a 40 mm cube would be 42 mm.
COLLISION_MARGIN = 1e-4
REACH = 5.0  # metres; whatever is further away did not get there by physics
SUNK = 0.05
PIN_STRENGTH = 1000.0  # newtons, and newton metres
# m/s; a fall from 40 cm ends at 3. Only a penetration that is undone at once makes more than this.
FASTEST = 10.0


class UnstableError(Exception):
    """The simulation went wrong: the object is nowhere, under the table, or shot away."""


class Pose(NamedTuple):
    """Where the object is: its center of mass in metres, and a quaternion (x, y, z, w)."""

    position: Floats
    quaternion: Floats

    @classmethod
    def of(cls, numbers: Sequence[float]) -> Self:
        """Of the three numbers of the position and the four of the quaternion."""
        return cls(np.array(numbers[:3]), np.array(numbers[3:]))

    @property
    def matrix(self) -> Floats:
        """The (4, 4) transform from the frame of `Model.mesh` to the world."""
        matrix = np.eye(4)
        matrix[:3, :3] = np.reshape(
            pybullet.getMatrixFromQuaternion(self.quaternion.tolist()), (3, 3)
        )
        matrix[:3, 3] = self.position
        return matrix


class Client:
    """One connection to the engine; its methods are the functions of `pybullet`."""

    def __init__(self) -> None:
        self._number = pybullet.connect(pybullet.DIRECT)

    def __getattr__(self, name: str) -> functools.partial[Any]:
        return functools.partial(getattr(pybullet, name), physicsClientId=self._number)


class World:
    """A table at height 0 and one object, simulated as long as the `with` block lasts.

    Attributes:
        model: The object.
        watch: Called after every time step, for films.
        client: The engine, for what else takes part.
        object: Number of the object in the engine.
        table: Number of the table in the engine.
    """

    def __init__(self, model: Model) -> None:
        """Prepare a world.

        Args:
            model: The object that lies on the table.
        """
        self.model = model
        self.watch: Callable[[World], None] | None = None

    def __enter__(self) -> Self:
        # The engine reads compounds and robots from files only.
        self._folder = tempfile.TemporaryDirectory()
        self._shape = Path(self._folder.name) / "parts.obj"
        self._shape.write_text(_wavefront(self.model), encoding="ascii")
        self.client = Client()
        self.reset()
        return self

    def __exit__(self, *_: object) -> None:
        self.client.disconnect()
        self._folder.cleanup()

    def reset(self) -> None:
        """Forget all that happened: only the table and the object, above it, are left."""
        self.client.resetSimulation()
        self.pull(GRAVITY)
        self.client.setPhysicsEngineParameter(
            fixedTimeStep=TIME_STEP,
            numSolverIterations=SOLVER_ITERATIONS,
            deterministicOverlappingPairs=1,
        )
        self.table = self._add_table()
        self.object = self._add_object()

    def pull(self, gravity: float) -> None:
        """Let this acceleration act downwards from now on, m/s2."""
        self.client.setGravity(0, 0, -gravity)

    @contextmanager
    def pinned(self) -> Iterator[None]:
        """Hold the object where it is, as long as the `with` block lasts."""
        place, free = self.pose(), (self.object, -1, -1, -1)
        pin = self.client.createConstraint(
            *free,
            pybullet.JOINT_FIXED,
            (0, 0, 0),
            (0, 0, 0),
            place.position.tolist(),
            childFrameOrientation=place.quaternion.tolist(),
        )
        self.client.changeConstraint(pin, maxForce=PIN_STRENGTH)
        try:
            yield
        finally:
            self.client.removeConstraint(pin)

    def place(self, pose: Pose) -> None:
        """Put the object somewhere, at rest."""
        self.client.resetBasePositionAndOrientation(
            self.object, pose.position.tolist(), pose.quaternion.tolist()
        )
        self.client.resetBaseVelocity(self.object, (0, 0, 0), (0, 0, 0))

    def pose(self) -> Pose:
        """Where the object is now.

        Raises:
            UnstableError: It is not finite, out of reach or under the table.
        """
        place = self.client.getBasePositionAndOrientation(self.object)
        position, quaternion = map(np.array, place)
        finite = np.isfinite(position).all() and np.isfinite(quaternion).all()
        if not finite or np.abs(position).max() > REACH or position[2] < -SUNK:
            raise UnstableError(f"the object is at {position}")
        return Pose(position, quaternion)

    def vertices(self) -> Floats:
        """The vertices of the object's surface where it is now, (n, 3)."""
        matrix = self.pose().matrix
        moved: Floats = self.model.mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        return moved

    def speeds(self) -> tuple[float, float]:
        """Speed of the object's center of mass in m/s, and its turning speed in rad/s."""
        linear, angular = self.client.getBaseVelocity(self.object)
        return float(np.linalg.norm(linear)), float(np.linalg.norm(angular))

    def force(self, first: int, second: int, link: int | None = None) -> float:
        """Normal forces between two bodies, in newtons, added up without their directions.

        Args:
            first: Number of a body.
            second: Number of the other body.
            link: A link of the first body; all of them if None.
        """
        where = {} if link is None else {"linkIndexA": link}
        contacts = self.client.getContactPoints(first, second, **where)
        return float(sum(contact[9] for contact in contacts))

    def step(self, steps: int = 1) -> None:
        """Advance the simulation by steps of 1/240 s.

        Raises:
            UnstableError: The object explodes: it gets faster than anything here can make it.
        """
        for _ in range(steps):
            self.client.stepSimulation()
            velocity = self.client.getBaseVelocity(self.object)[0]
            if not math.hypot(*velocity) < FASTEST:  # which a NaN is not, either
                raise UnstableError("the object was thrown away")
            if self.watch is not None:
                self.watch(self)

    def add_robot(
        self, description: str, position: Sequence[float], quaternion: Sequence[float]
    ) -> int:
        """Add a robot with its base fixed.

        Args:
            description: URDF.
            position: Of its base.
            quaternion: Of its base.

        Returns:
            Its number in the engine.
        """
        path = Path(self._folder.name) / "robot.urdf"
        path.write_text(description, encoding="utf-8")
        number: int = self.client.loadURDF(str(path), position, quaternion, useFixedBase=1)
        return number

    def _add_table(self) -> int:
        plane = self.client.createCollisionShape(pybullet.GEOM_PLANE)
        table: int = self.client.createMultiBody(0, plane)
        self.client.changeDynamics(
            table,
            -1,
            lateralFriction=TABLE_FRICTION,
            rollingFriction=TABLE_ROLLING,
            spinningFriction=TABLE_ROLLING,
        )
        return table

    def _add_object(self) -> int:
        shape = self.client.createCollisionShape(pybullet.GEOM_MESH, fileName=str(self._shape))
        above = (0, 0, float(self.model.mesh.scale))
        body: int = self.client.createMultiBody(self.model.mass, shape, basePosition=above)
        self.client.changeDynamics(
            body,
            -1,
            lateralFriction=OBJECT_FRICTION,
            # Contacts remember where they stuck. Without, a cube held for 10 s at 20 N sinks by
            # 0.06 mm and turns by 1.5 degrees. The friction cone still limits the force.
            frictionAnchor=1,
            localInertiaDiagonal=self.model.inertia.tolist(),
            collisionMargin=COLLISION_MARGIN,
        )
        return body


def _wavefront(model: Model) -> str:
    """The parts as objects of one OBJ file; the engine takes the hull of each."""
    lines, first = [], 1
    for number, part in enumerate(model.parts):
        lines.append(f"o part{number}")
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in part.vertices]
        lines += [f"f {a} {b} {c}" for a, b, c in part.faces + first]
        first += len(part.vertices)
    return "\n".join([*lines, ""])
