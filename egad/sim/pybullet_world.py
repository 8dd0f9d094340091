"""The simulated world in PyBullet."""

import math
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation
from typing_extensions import override

from egad._util.arrays import Floats
from egad.friction import OBJECT
from egad.sim.drives import LEFT, RIGHT
from egad.sim.pybullet_scene import (
    Client,
    Linkage,
    add_gear,
    add_object,
    add_table,
    add_wall,
    wavefront,
)
from egad.sim.robot import PALM, wall_boxes
from egad.sim.urdf import hull_files, to_urdf
from egad.sim.world import CLOSING_SPEED, DOWN, TIME_STEP, Forces, Pose, World

# Enough for light, thin objects in a strong hand; figures are in studies/engines/README.md.
SOLVER_ITERATIONS = 150
URDF_MARGIN = 1e-3  # metres that it also adds around meshes in URDF
WELD_STRENGTH = 1e5  # newtons, and newton metres
PIN_STRENGTH = 1000.0  # newtons, and newton metres
POSITION_GAIN = 0.3  # fraction of an error that is corrected in one step
# The gear must be stronger than the fingers, or an object off the middle holds one of them up.
GEAR_STRENGTH = 10
FREE = (-1, -1, -1)
NORMAL_FORCE, LINK = 9, 3  # positions in the engine's tuple of a contact


class PyBulletWorld(World):
    """A world in PyBullet: the engine is `client`, objects and table are numbers in it."""

    def __enter__(self) -> Self:
        # The engine reads compound shapes and robots only from files.
        self._folder = tempfile.TemporaryDirectory()
        for number, model in enumerate(self.models):
            self._shape(number).write_text(wavefront(model), encoding="ascii")
        self._description = Path(self._folder.name) / "robot.urdf"
        if self.robot is not None:
            self._description.write_text(to_urdf(self.robot), encoding="utf-8")
            for name, text in hull_files(self.robot, URDF_MARGIN).items():
                (self._description.parent / name).write_text(text, encoding="ascii")
        self.client = Client()
        self.reset()
        return self

    def __exit__(self, *_: object) -> None:
        self.client.disconnect()
        self._folder.cleanup()

    @override
    def reset(self) -> None:
        self.client.resetSimulation()
        self.set_gravity(DOWN)
        self.client.setPhysicsEngineParameter(
            fixedTimeStep=TIME_STEP,
            numSolverIterations=SOLVER_ITERATIONS,
            deterministicOverlappingPairs=1,
        )
        # The engine multiplies the friction of two bodies; with 1 for an object, the other decides.
        self._friction = 1.0 if len(self.models) == 1 else math.sqrt(OBJECT.friction)
        self.table = add_table(self.client, self._friction)
        self._walls = [
            add_wall(self.client, box, self._friction)
            for box in (wall_boxes(self.walls) if self.walls else [])
        ]
        self.objects = [
            add_object(self.client, model, self._shape(number), self._friction, self.mass_factor)
            for number, model in enumerate(self.models)
        ]
        self._constraints: dict[int, int] = {}
        self._robot: int | None = None
        self.attached = None
        if len(self.models) > 1:
            for number in range(len(self.models)):
                self.park(number)

    @override
    def set_gravity(self, acceleration: Sequence[float]) -> None:
        self.client.setGravity(*acceleration)

    @override
    def place(
        self,
        pose: Pose,
        velocity: Sequence[float] = (0.0, 0.0, 0.0),
        turning: Sequence[float] = (0.0, 0.0, 0.0),
        number: int = 0,
    ) -> None:
        body = self.objects[number]
        self.client.resetBasePositionAndOrientation(
            body, pose.position.tolist(), pose.quaternion.tolist()
        )
        self.client.resetBaseVelocity(body, velocity, turning)
        self._unpin(number)

    @override
    def remove_walls(self) -> None:
        while self._walls:
            self.client.removeBody(self._walls.pop())

    @override
    def put_robot(self, base: Pose, joints: Sequence[float], opening: float) -> None:
        robot = self.known_robot
        place = base.position.tolist(), base.quaternion.tolist()
        self._robot = self.client.loadURDF(str(self._description), *place, useFixedBase=1)
        count = self.client.getNumJoints(self._robot)
        names = [self.client.getJointInfo(self._robot, joint)[1].decode() for joint in range(count)]
        self._arm = [names.index(name) for name in robot.arm]
        self._names = names
        self._fingers = tuple(names.index(name) for name in robot.drive.joints)
        self._sides = {names.index(link): side for link, side in robot.sides.items()}
        for joint, position in zip(self._arm, joints, strict=True):
            self.client.resetJointState(self._robot, joint, position, 0)
        self.drive(joints, [0.0] * len(self._arm))
        self._set_friction(count)
        if self._fingers:
            self._hold_fingers(self._robot, opening)
        couplings = [
            (each, names.index(each.joint), self._fingers[each.side == RIGHT])
            for each in robot.followers
        ]
        self._linkage = Linkage(self.client, self._robot, couplings, opening)

    @override
    def drive(self, joints: Sequence[float], speeds: Sequence[float]) -> None:
        self.client.setJointMotorControlArray(
            self._robot,
            self._arm,
            pybullet.POSITION_CONTROL,
            targetPositions=list(joints),
            targetVelocities=list(speeds),
            positionGains=[POSITION_GAIN] * len(self._arm),
            forces=list(self.known_robot.strength.values()),
        )

    @override
    def close_fingers(self) -> None:
        drive = self.known_robot.drive
        for finger in self._fingers:
            self.client.setJointMotorControl2(
                self._robot,
                finger,
                pybullet.VELOCITY_CONTROL,
                targetVelocity=drive.closing * CLOSING_SPEED,
                force=drive.strength,
            )

    @override
    def arm_joints(self) -> Floats:
        states = self.client.getJointStates(self._robot, self._arm)
        return np.array([state[0] for state in states])

    @override
    def fingers(self) -> tuple[Floats, Floats]:
        states = self.client.getJointStates(self._robot, self._fingers) if self._fingers else ()
        positions, speeds = (np.array([state[each] for state in states]) for each in (0, 1))
        return self.known_robot.drive.pads(positions, speeds)

    @override
    def forces(self, number: int | None = None) -> Forces:
        chosen = self.objects if number is None else [self.objects[number]]
        support = sum(self._force(self.table, body) for body in chosen)
        if self._robot is None:
            return Forces(0.0, 0.0, 0.0, support, 0.0)
        contacts = [
            contact
            for body in chosen
            for contact in self.client.getContactPoints(self._robot, body)
        ]
        left, right, rest = (
            _normal_force(each for each in contacts if self._sides.get(each[LINK]) == side)
            for side in (LEFT, RIGHT, None)
        )
        return Forces(left, right, rest, support, self._force(self.table, self._robot))

    @override
    def link_poses(self) -> list[Pose]:
        if self._robot is None:
            return []
        root = self.client.getBasePositionAndOrientation(self._robot)
        numbers = range(self.client.getNumJoints(self._robot))
        states = self.client.getLinkStates(self._robot, numbers, computeForwardKinematics=1)
        places = [root, *((state[4], state[5]) for state in states)]
        return [Pose(np.array(position), np.array(turn)) for position, turn in places]

    @override
    def speeds(self) -> tuple[float, float]:
        velocities = [self.client.getBaseVelocity(body) for body in self.objects]
        linear = max(float(np.linalg.norm(velocity[0])) for velocity in velocities)
        return linear, max(float(np.linalg.norm(velocity[1])) for velocity in velocities)

    def _numbers(self, number: int) -> tuple[Sequence[float], Sequence[float]]:
        position, quaternion = self.client.getBasePositionAndOrientation(self.objects[number])
        return position, quaternion

    def _advance(self) -> float:
        if self._robot is not None:
            self._linkage.turn()
        self.client.stepSimulation()
        return self.speeds()[0]

    def _attach(self, pose: Floats, number: int) -> None:
        palm = self._names.index(PALM)
        turn = Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()
        self._weld = self.client.createConstraint(
            self._robot,
            palm,
            self.objects[number],
            -1,
            pybullet.JOINT_FIXED,
            (0, 0, 0),
            self._in_link(palm, pose[:3, 3]),
            (0, 0, 0),
            turn,
        )
        self.client.changeConstraint(self._weld, maxForce=WELD_STRENGTH)

    def _in_link(self, link: int, point: Floats) -> list[float]:
        """A point in the frame of a link, relative to the frame of its center of mass."""
        inertial = np.array(self.client.getDynamicsInfo(self._robot, link)[3])
        place: list[float] = (point - inertial).tolist()
        return place

    def _detach(self, number: int) -> None:
        del number
        self.client.removeConstraint(self._weld)

    def _pull(self, number: int) -> Floats:
        del number
        on_palm = np.array(self.client.getConstraintState(self._weld))
        return -on_palm.reshape(2, 3)

    def _pin(self, pose: Pose, number: int) -> None:
        constraint = self.client.createConstraint(
            self.objects[number],
            *FREE,
            pybullet.JOINT_FIXED,
            (0, 0, 0),
            (0, 0, 0),
            pose.position.tolist(),
            childFrameOrientation=pose.quaternion.tolist(),
        )
        self.client.changeConstraint(constraint, maxForce=PIN_STRENGTH)
        self._constraints[number] = constraint

    def _unpin(self, number: int) -> None:
        if number in self._constraints:
            self.client.removeConstraint(self._constraints.pop(number))

    def _shape(self, number: int) -> Path:
        return Path(self._folder.name) / f"parts{number}.obj"

    def _force(self, first: int, second: int) -> float:
        return _normal_force(self.client.getContactPoints(first, second))

    def _set_friction(self, joints: int) -> None:
        pad = self.known_robot.gripper.pad
        for link in range(joints):
            self.client.changeDynamics(
                self._robot,
                link,
                lateralFriction=self.friction_factor * pad.friction / self._friction,
                spinningFriction=self.friction_factor * pad.torsion / self._friction,
            )

    def _hold_fingers(self, body: int, opening: float) -> None:
        """Hold the fingers where they are; a gear keeps two from drifting sideways together."""
        drive = self.known_robot.drive
        force, position = drive.strength, drive.position(opening)
        for finger in self._fingers:
            self.client.resetJointState(body, finger, position, 0)
            self.client.setJointMotorControl2(
                body, finger, pybullet.POSITION_CONTROL, position, force=force
            )
        if not drive.mirrored:
            return
        gear = add_gear(self.client, body, *self._fingers)
        self.client.changeConstraint(gear, gearRatio=-1, maxForce=GEAR_STRENGTH * force)


def _normal_force(contacts: Iterable[Sequence[Any]]) -> float:
    return float(sum(contact[NORMAL_FORCE] for contact in contacts))
