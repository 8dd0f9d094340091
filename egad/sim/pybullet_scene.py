"""The scene as PyBullet needs it: table, walls, objects and the joints of linkages."""

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pybullet

from egad.friction import OBJECT, TABLE, TABLE_ROLLING
from egad.sim.drives import Follower
from egad.sim.model import Model
from egad.sim.robot import Box

# The engine's 1 mm is added all around convex parts: a 40 mm cube would be 42 mm.
COLLISION_MARGIN = 1e-4
LINKAGE_GAIN, LINKAGE_STRENGTH = 0.9, 1e5  # newtons or newton metres


class Client:
    """One connection to the engine; its methods are the functions of `pybullet`."""

    def __init__(self) -> None:
        self._number = pybullet.connect(pybullet.DIRECT)

    def __getattr__(self, name: str) -> functools.partial[Any]:
        return functools.partial(getattr(pybullet, name), physicsClientId=self._number)


def add_table(client: Client, friction: float) -> int:
    """Add the table; the friction is that of the objects."""
    plane = client.createCollisionShape(pybullet.GEOM_PLANE)
    table: int = client.createMultiBody(0, plane)
    client.changeDynamics(
        table,
        -1,
        lateralFriction=TABLE.friction / friction,
        rollingFriction=TABLE_ROLLING / friction,
        spinningFriction=TABLE_ROLLING / friction,
    )
    return table


def add_wall(client: Client, box: Box, friction: float) -> int:
    """Add a wall; the friction is that of the objects."""
    half = [side / 2 for side in box.size]
    shape = client.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half)
    wall: int = client.createMultiBody(0, shape, basePosition=box.center)
    client.changeDynamics(wall, -1, lateralFriction=OBJECT.friction / friction)
    return wall


def add_object(
    client: Client, model: Model, file: Path, friction: float, mass_factor: float
) -> int:
    """Add an object, above the table, with its parts in a file and its mass times a factor."""
    shape = client.createCollisionShape(pybullet.GEOM_MESH, fileName=str(file))
    above = (0, 0, float(model.mesh.scale))
    body: int = client.createMultiBody(mass_factor * model.mass, shape, basePosition=above)
    client.changeDynamics(
        body,
        -1,
        lateralFriction=friction,
        # Contacts remember where they stuck; otherwise held objects creep and turn. The
        # friction cone still limits the force.
        frictionAnchor=1,
        localInertiaDiagonal=(mass_factor * model.inertia).tolist(),
        collisionMargin=COLLISION_MARGIN,
    )
    return body


def wavefront(model: Model) -> str:
    """The parts as objects of one OBJ file; the engine uses the hull of each."""
    lines, first = [], 1
    for number, part in enumerate(model.parts):
        lines.append(f"o part{number}")
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in part.vertices]
        lines += [f"f {a} {b} {c}" for a, b, c in part.faces + first]
        first += len(part.vertices)
    return "\n".join([*lines, ""])


class Linkage:
    """The joints of a linkage, each coupled to that of its finger by a gear."""

    def __init__(
        self,
        client: Client,
        robot: int,
        couplings: Sequence[tuple[Follower, int, int]],
        opening: float,
    ) -> None:
        """Set the joints to their positions at an opening, metres.

        The couplings are followers with the numbers of their joints and of those of their fingers.
        """
        self._client, self._robot = client, robot
        self._gears = []
        for follower, joint, finger in couplings:
            client.resetJointState(robot, joint, follower.at(opening / 2), 0)
            client.setJointMotorControl2(robot, joint, pybullet.VELOCITY_CONTROL, force=0)
            self._gears.append((add_gear(client, robot, joint, finger), follower, finger))
        self.turn()

    def turn(self) -> None:
        """Give each gear, which is linear, the slope of its curve at the current position."""
        for gear, follower, finger in self._gears:
            distance = self._client.getJointState(self._robot, finger)[0]
            slope = follower.slope(distance)
            self._client.changeConstraint(
                gear,
                gearRatio=-slope,
                relativePositionTarget=follower.at(distance) - slope * distance,
                erp=LINKAGE_GAIN,
                maxForce=LINKAGE_STRENGTH,
            )


def add_gear(client: Client, robot: int, first: int, second: int) -> int:
    """Add a constraint between two joints of the robot."""
    at = (0, 0, 0)
    gear: int = client.createConstraint(
        robot, first, robot, second, pybullet.JOINT_GEAR, (1, 0, 0), at, at
    )
    return gear
