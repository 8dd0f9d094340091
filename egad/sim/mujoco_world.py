"""The simulated world in MuJoCo."""

import logging
import math
from collections.abc import Mapping, Sequence
from typing import Self

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation
from typing_extensions import override

from egad._util.arrays import Floats
from egad.sim.model import Model
from egad.sim.mujoco_model import (
    CLOSE,
    HOLD,
    OBJECT,
    OBJECT_BIT,
    ROBOT,
    TABLE_BIT,
    WALL,
    scene_spec,
)
from egad.sim.robot import Robot
from egad.sim.servos import DAMPING_TIME, SUBSTEPS
from egad.sim.world import (
    CLOSING_SPEED,
    DOWN,
    FINGERS,
    FIRST_OBJECT,
    LEFT_FINGER,
    OTHERS,
    RIGHT_FINGER,
    TABLE,
    WALLS,
    Forces,
    Pose,
    UnstableError,
    World,
)

log = logging.getLogger(__name__)


class MujocoWorld(World):
    """A world in MuJoCo: the compiled model, `engine`, and its state, `data`."""

    def __init__(
        self, models: Sequence[Model], robot: Robot | None = None, walls: float | None = None
    ) -> None:
        super().__init__(models, robot, walls)
        mujoco.set_mju_user_warning(log.debug)  # otherwise it writes a file to the current folder
        self.engine = scene_spec(self.models, robot, walls).compile()
        self.data = mujoco.MjData(self.engine)
        engine = self.engine
        numbers = range(len(self.models))
        sides = {} if robot is None else robot.sides
        self._owners = np.array([_owner(engine, shape, sides) for shape in range(engine.ngeom)])
        self._pins = [engine.body(f"pin{number}").mocapid[0] for number in numbers]
        joints = [engine.body(f"{OBJECT}{number}").jntadr[0] for number in numbers]
        self._positions = engine.jnt_qposadr[joints]
        self._speeds = engine.jnt_dofadr[joints]
        if robot is not None:
            self._base = engine.body("base").mocapid[0]
            self._links = np.array([engine.body(ROBOT + link.name).id for link in robot.links])
            self._arm = _Joints(engine, robot.arm)
            self._fingers = _Joints(engine, robot.drive.joints)
            self._followers = _Joints(engine, [each.joint for each in robot.followers])
            count, fingers = len(robot.arm), len(robot.drive.joints)
            self._arm_control = slice(0, count)
            self._hold_control = slice(count, count + fingers)
            self._close_control = slice(count + fingers, count + 2 * fingers)
        self._factors = self.mass_factor, self.friction_factor
        self.reset()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    @override
    def reset(self) -> None:
        if (self.mass_factor, self.friction_factor) != self._factors:
            self._vary()
        mujoco.mj_resetData(self.engine, self.data)
        self.set_gravity(DOWN)
        self.engine.opt.disableactuator = 1 << CLOSE
        if self.robot is not None:
            self.data.qpos[self._arm.positions] = self._arm.middles
        self.engine.geom_contype[self._owners == WALLS] = TABLE_BIT
        self.engine.geom_conaffinity[self._owners == WALLS] = OBJECT_BIT
        self._here, self.attached = False, None
        self._place_objects()

    @override
    def set_gravity(self, acceleration: Sequence[float]) -> None:
        self.engine.opt.gravity[:] = acceleration

    @override
    def place(
        self,
        pose: Pose,
        velocity: Sequence[float] = (0.0, 0.0, 0.0),
        turning: Sequence[float] = (0.0, 0.0, 0.0),
        number: int = 0,
    ) -> None:
        place, speed = self._positions[number], self._speeds[number]
        self.data.qpos[place : place + 3] = pose.position
        self.data.qpos[place + 3 : place + 7] = _scalar_first(pose.quaternion)
        self.data.qvel[speed : speed + 3] = velocity
        self.data.qvel[speed + 3 : speed + 6] = pose.matrix[:3, :3].T @ turning
        self.data.qacc_warmstart[:] = 0
        self._unpin(number)

    @override
    def remove_walls(self) -> None:
        self.engine.geom_contype[self._owners == WALLS] = 0
        self.engine.geom_conaffinity[self._owners == WALLS] = 0

    @override
    def put_robot(self, base: Pose, joints: Sequence[float], opening: float) -> None:
        robot = self.known_robot
        self.data.mocap_pos[self._base] = base.position
        self.data.mocap_quat[self._base] = _scalar_first(base.quaternion)
        self.data.qpos[self._arm.positions] = joints
        self.data.qvel[self._arm.speeds] = 0
        self.data.qpos[self._fingers.positions] = robot.drive.position(opening)
        self.data.qvel[self._fingers.speeds] = 0
        followers = [each.at(opening / 2) for each in robot.followers]
        self.data.qpos[self._followers.positions] = followers
        self.data.qvel[self._followers.speeds] = 0
        self.data.qacc_warmstart[:] = 0
        self.drive(joints, [0.0] * len(joints))
        self.data.ctrl[self._hold_control] = robot.drive.position(opening)
        self.engine.opt.disableactuator = 1 << CLOSE
        self._here = True

    @override
    def drive(self, joints: Sequence[float], speeds: Sequence[float]) -> None:
        self.data.ctrl[self._arm_control] = joints + DAMPING_TIME * np.asarray(speeds)

    @override
    def close_fingers(self) -> None:
        self.data.ctrl[self._close_control] = self.known_robot.drive.closing * CLOSING_SPEED
        self.engine.opt.disableactuator = 1 << HOLD

    @override
    def arm_joints(self) -> Floats:
        joints: Floats = self.data.qpos[self._arm.positions]
        return joints

    @override
    def fingers(self) -> tuple[Floats, Floats]:
        positions, speeds = self._fingers.positions, self._fingers.speeds
        return self.known_robot.drive.pads(self.data.qpos[positions], self.data.qvel[speeds])

    @override
    def forces(self, number: int | None = None) -> Forces:
        contact, count = self.data.contact, FIRST_OBJECT + len(self.models)
        first = contact.efc_address
        pairs = np.sort(self._owners[contact.geom[first >= 0]], axis=1)
        # The first number of each contact is the normal force.
        sums = np.zeros((count, count))
        np.add.at(sums, (pairs[:, 0], pairs[:, 1]), self.data.efc_force[first[first >= 0]])
        return Forces.between(sums, number)

    @override
    def link_poses(self) -> list[Pose]:
        if not self._here:
            return []
        mujoco.mj_kinematics(self.engine, self.data)
        return [
            Pose(self.data.xpos[link].copy(), np.roll(self.data.xquat[link], -1))
            for link in self._links
        ]

    @override
    def speeds(self) -> tuple[float, float]:
        velocities = [self.data.qvel[speed : speed + 6] for speed in self._speeds]
        linear = max(float(np.linalg.norm(velocity[:3])) for velocity in velocities)
        return linear, max(float(np.linalg.norm(velocity[3:])) for velocity in velocities)

    def _vary(self) -> None:
        """Apply the current factors to the mass of the objects and the friction of the robot."""
        for number, model in enumerate(self.models):
            body = self.engine.body(f"{OBJECT}{number}").id
            self.engine.body_mass[body] = self.mass_factor * model.mass
            self.engine.body_inertia[body] = self.mass_factor * model.inertia
        if self.robot is not None:
            pad = self.robot.gripper.pad
            pads = np.isin(self._owners, (LEFT_FINGER, RIGHT_FINGER, OTHERS))
            self.engine.geom_friction[pads, :2] = self.friction_factor * np.array(
                [pad.friction, pad.torsion]
            )
        mujoco.mj_setConst(self.engine, self.data)
        self._factors = self.mass_factor, self.friction_factor

    def _numbers(self, number: int) -> tuple[Sequence[float], Sequence[float]]:
        place = self._positions[number]
        numbers = self.data.qpos[place : place + 7].tolist()
        return numbers[:3], [*numbers[4:], numbers[3]]

    def _advance(self) -> float:
        if self.attached is None:
            mujoco.mj_step(self.engine, self.data, SUBSTEPS)
        else:
            # Servos jump to a new target once per time step: only the mean pull is meaningful.
            pulls = []
            for _ in range(SUBSTEPS):
                mujoco.mj_step(self.engine, self.data)
                pulls.append(self._pull_now(self.attached))
            self._mean_pull = np.mean(pulls, axis=0)
        warnings = self.data.warning
        if warnings.number.any():
            number = int(np.argmax(warnings.number > 0))
            raise UnstableError(mujoco.mju_warningText(number, int(warnings.lastinfo[number])))
        speeds = [math.hypot(*self.data.qvel[speed : speed + 3]) for speed in self._speeds]
        return sum(speeds) if any(map(math.isnan, speeds)) else max(speeds)

    def _attach(self, pose: Floats, number: int) -> None:
        weld = len(self.models) + number
        self._mean_pull = np.zeros((2, 3))
        self.engine.eq_data[weld, :3] = 0
        self.engine.eq_data[weld, 3:6] = pose[:3, 3]
        turn = Rotation.from_matrix(pose[:3, :3]).as_quat()
        self.engine.eq_data[weld, 6:10] = _scalar_first(turn)
        self.data.eq_active[weld] = 1

    def _detach(self, number: int) -> None:
        self.data.eq_active[len(self.models) + number] = 0

    def _pull(self, number: int) -> Floats:
        del number
        mean: Floats = self._mean_pull
        return mean

    def _pull_now(self, number: int) -> Floats:
        """Same as `_pull`, but for the last of the engine's own steps."""
        weld = len(self.models) + number
        data, count = self.data, self.data.nefc
        rows = (data.efc_type[:count] == mujoco.mjtConstraint.mjCNSTR_EQUALITY) & (
            data.efc_id[:count] == weld
        )
        forces = np.zeros(self.engine.nv)
        mujoco.mj_mulJacTVec(self.engine, data, forces, np.where(rows, data.efc_force[:count], 0.0))
        speed = self._speeds[number]
        turn = self.pose(number).matrix[:3, :3]
        return np.stack([forces[speed : speed + 3], turn @ forces[speed + 3 : speed + 6]])

    def _pin(self, pose: Pose, number: int) -> None:
        self.data.mocap_pos[self._pins[number]] = pose.position
        self.data.mocap_quat[self._pins[number]] = _scalar_first(pose.quaternion)
        self.data.eq_active[number] = 1

    def _unpin(self, number: int) -> None:
        self.data.eq_active[number] = 0


class _Joints:
    """Where positions and speeds of joints are in the state, and the middles of their ranges."""

    def __init__(self, engine: mujoco.MjModel, names: Sequence[str]) -> None:
        joints = [engine.joint(ROBOT + name) for name in names]
        self.positions = np.array([joint.qposadr[0] for joint in joints], dtype=int)
        self.speeds = np.array([joint.dofadr[0] for joint in joints], dtype=int)
        self.middles = np.array([joint.range.mean() for joint in joints])


def _scalar_first(quaternion: Floats) -> Floats:
    return np.roll(quaternion, 1)


def _owner(engine: mujoco.MjModel, shape: int, sides: Mapping[str, str]) -> int:
    body = engine.body(engine.geom_bodyid[shape]).name
    if body.startswith(OBJECT):
        return FIRST_OBJECT + int(body.removeprefix(OBJECT))
    if body == "world":
        return WALLS if engine.geom(shape).name.startswith(WALL) else TABLE
    side = sides.get(body.removeprefix(ROBOT))
    return FINGERS.get(side or "", OTHERS)
