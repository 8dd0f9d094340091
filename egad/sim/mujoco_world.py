"""The simulated world in MuJoCo."""

import logging
from collections.abc import Sequence
from typing import Self

import mujoco
import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from egad.sim.model import Model
from egad.sim.mujoco_model import CLOSE, DAMPING_TIME, HOLD, ROBOT, SUBSTEPS, described
from egad.sim.robot import LEFT, RIGHT, Robot
from egad.sim.world import CLOSING_SPEED, DOWN, Forces, Pose, World

log = logging.getLogger(__name__)
Floats = NDArray[np.float64]

TABLE, OBJECT, LEFT_FINGER, RIGHT_FINGER, OTHERS = range(5)  # owners of shapes


class MujocoWorld(World):
    """A world in MuJoCo.

    Attributes:
        engine: The compiled model.
        data: The state of the engine.
    """

    def __init__(self, model: Model, robot: Robot | None = None) -> None:
        super().__init__(model, robot)
        mujoco.set_mju_user_warning(log.debug)  # else it writes a file into the current folder
        self.engine = described(model, robot).compile()
        self.data = mujoco.MjData(self.engine)
        engine = self.engine
        self._owners = np.array([_owner(engine, body) for body in engine.geom_bodyid])
        self._pin_body = engine.body("pin").mocapid[0]
        if robot is not None:
            self._base = engine.body("base").mocapid[0]
            self._links = np.array([engine.body(ROBOT + link.name).id for link in robot.links])
            self._arm = _Joints(engine, robot.arm)
            self._fingers = _Joints(engine, (LEFT, RIGHT))
            count = len(robot.arm)
            self._arm_control = slice(0, count)
            self._hold_control = slice(count, count + 2)
            self._close_control = slice(count + 2, count + 4)
        self.reset()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    @override
    def reset(self) -> None:
        mujoco.mj_resetData(self.engine, self.data)
        self.set_gravity(DOWN)
        self.data.qpos[2] = float(self.model.mesh.scale)
        self._here = False

    @override
    def set_gravity(self, acceleration: Sequence[float]) -> None:
        self.engine.opt.gravity[:] = acceleration

    @override
    def place(
        self,
        pose: Pose,
        velocity: Sequence[float] = (0.0, 0.0, 0.0),
        turning: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        self.data.qpos[:3] = pose.position
        self.data.qpos[3:7] = _scalar_first(pose.quaternion)
        self.data.qvel[:3] = velocity
        self.data.qvel[3:6] = pose.matrix[:3, :3].T @ turning
        self.data.qacc_warmstart[:] = 0

    @override
    def put_robot(self, base: Pose, joints: Sequence[float], opening: float) -> None:
        self.data.mocap_pos[self._base] = base.position
        self.data.mocap_quat[self._base] = _scalar_first(base.quaternion)
        self.data.qpos[self._arm.positions] = joints
        self.data.qvel[self._arm.speeds] = 0
        self.data.qpos[self._fingers.positions] = opening / 2
        self.data.qvel[self._fingers.speeds] = 0
        self.data.qacc_warmstart[:] = 0
        self.drive(joints, [0.0] * len(joints))
        self.data.ctrl[self._hold_control] = opening / 2
        self.engine.opt.disableactuator = 1 << CLOSE
        self._here = True

    @override
    def drive(self, joints: Sequence[float], speeds: Sequence[float]) -> None:
        self.data.ctrl[self._arm_control] = joints + DAMPING_TIME * np.asarray(speeds)

    @override
    def close_fingers(self) -> None:
        self.data.ctrl[self._close_control] = -CLOSING_SPEED
        self.engine.opt.disableactuator = 1 << HOLD

    @override
    def arm_joints(self) -> Floats:
        joints: Floats = self.data.qpos[self._arm.positions]
        return joints

    @override
    def fingers(self) -> tuple[Floats, Floats]:
        return self.data.qpos[self._fingers.positions], self.data.qvel[self._fingers.speeds]

    @override
    def forces(self) -> Forces:
        contact = self.data.contact
        first = contact.efc_address
        pairs = np.sort(self._owners[contact.geom[first >= 0]], axis=1)
        # Of each contact, the first number is the normal force.
        normal = self.data.efc_force[first[first >= 0]]
        sums = np.bincount(pairs[:, 0] * 5 + pairs[:, 1], normal, 25).reshape(5, 5)
        left, right, rest = sums[OBJECT, LEFT_FINGER:].tolist()
        return Forces(
            left,
            right,
            rest,
            support=float(sums[TABLE, OBJECT]),
            blocked=float(sums[TABLE, LEFT_FINGER:].sum()),
        )

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
        velocity = self.data.qvel
        return float(np.linalg.norm(velocity[:3])), float(np.linalg.norm(velocity[3:6]))

    def _numbers(self) -> tuple[Sequence[float], Sequence[float]]:
        numbers = self.data.qpos[:7].tolist()
        return numbers[:3], [*numbers[4:], numbers[3]]

    def _advance(self) -> Sequence[float]:
        mujoco.mj_step(self.engine, self.data, SUBSTEPS)
        velocity: list[float] = self.data.qvel[:3].tolist()
        return velocity

    def _pin(self, pose: Pose) -> None:
        self.data.mocap_pos[self._pin_body] = pose.position
        self.data.mocap_quat[self._pin_body] = _scalar_first(pose.quaternion)
        self.data.eq_active[0] = 1

    def _unpin(self) -> None:
        self.data.eq_active[0] = 0


class _Joints:
    """Where positions and speeds of joints are in the state."""

    def __init__(self, engine: mujoco.MjModel, names: Sequence[str]) -> None:
        joints = [engine.joint(ROBOT + name) for name in names]
        self.positions = np.array([joint.qposadr[0] for joint in joints])
        self.speeds = np.array([joint.dofadr[0] for joint in joints])


def _scalar_first(quaternion: Floats) -> Floats:
    return np.roll(quaternion, 1)


def _owner(engine: mujoco.MjModel, body: int) -> int:
    names = {
        "world": TABLE,
        "object": OBJECT,
        ROBOT + LEFT: LEFT_FINGER,
        ROBOT + RIGHT: RIGHT_FINGER,
    }
    return names.get(engine.body(body).name, OTHERS)
