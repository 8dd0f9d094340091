"""The simulated world in MuJoCo."""

import logging
from collections.abc import Sequence
from typing import Self

import mujoco
import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from egad.sim.model import Model
from egad.sim.robot import LEFT, RIGHT, Robot, to_urdf
from egad.sim.world import DOWN, TABLE_FRICTION, TABLE_ROLLING, TIME_STEP, Forces, Pose, World

log = logging.getLogger(__name__)
Floats = NDArray[np.float64]

SUBSTEPS = 2  # of a time step
# Contacts are soft: the stiffest that the step allows, and close to rigid.
CONTACT_TIME = 2 * TIME_STEP / SUBSTEPS  # seconds, within which a penetration is undone
IMPEDANCE = (0.99, 0.995, 0.0005, 0.5, 2.0)
FRICTION_STIFFNESS = 100.0  # of friction against normal forces, or held objects creep
# Of servos. Stiff, but with the lag that any controller has.
SLACK = 0.01  # metres or radians off the target, where an arm uses all its strength
DAMPING_TIME = 0.02  # seconds
FINGER_SLACK = 0.002  # metres
# m/s; the force of a finger falls with its speed as that of a motor, and is zero at this one
FINGER_SPEED = 0.1
LEAST_INERTIA = 1e-6  # kg and kg m2; links without mass are not allowed
ARMATURE = 0.004  # s2/m or s2: inertia of what drives a joint, by its strength
PARKED = (0.0, 0.0, 3.0)  # where a robot waits that takes no part
ROBOT = "robot-"  # before the names of its links and joints
HOLD, CLOSE = 0, 1  # groups of actuators of the fingers
# Bits of what collides: the object with table and robot, and these two with each other.
OBJECT_BIT, TABLE_BIT = 1, 2
TABLE, OBJECT, LEFT_FINGER, RIGHT_FINGER, OTHERS = range(5)  # owners of shapes
CONTACT_DIMENSIONS, PAD_DIMENSIONS = 6, 4  # with torsion, that of the table with rolling, too


class MujocoWorld(World):
    """A world in MuJoCo.

    Attributes:
        engine: The compiled model.
        data: The state of the engine.
    """

    def __init__(self, model: Model, robot: Robot | None = None) -> None:
        super().__init__(model, robot)
        mujoco.set_mju_user_warning(log.debug)  # else it writes a file into the current folder
        self.engine = _described(model, robot).compile()
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
            self._strength = np.array(list(robot.strength.values()))
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
    def close_fingers(self, speed: float) -> None:
        self.data.ctrl[self._close_control] = -speed
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


def _described(model: Model, robot: Robot | None) -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    option = spec.option
    option.timestep = TIME_STEP / SUBSTEPS
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = FRICTION_STIFFNESS
    option.disableflags = mujoco.mjtDisableBit.mjDSBL_AUTORESET  # what explodes is to be seen
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[1, 1, 1],
        friction=[TABLE_FRICTION, TABLE_ROLLING, TABLE_ROLLING],
        priority=1,
        contype=TABLE_BIT,
        conaffinity=OBJECT_BIT,
        **_CONTACT,
    )
    _add_object(spec, model)
    if robot is not None:
        _add_robot(spec, robot)
    return spec


_CONTACT = {
    "condim": CONTACT_DIMENSIONS,
    "solref": [CONTACT_TIME, 1.0],
    "solimp": list(IMPEDANCE),
}


def _add_object(spec: mujoco.MjSpec, model: Model) -> None:
    body = spec.worldbody.add_body(name="object")
    body.add_freejoint()
    body.explicitinertial = True
    body.mass, body.inertia = model.mass, model.inertia
    for number, part in enumerate(model.parts):
        name = f"part{number}"
        spec.add_mesh(
            name=name,
            uservert=part.vertices.ravel(),
            userface=part.faces.ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
        )
        # The friction is that of what it touches, whose priority is higher.
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=name,
            mass=0,
            contype=OBJECT_BIT,
            conaffinity=0,
            **_CONTACT,
        )
    pin = spec.worldbody.add_body(name="pin", mocap=True)
    equality = spec.add_equality(
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=pin.name,
        name2=body.name,
        active=False,
    )
    equality.data[:11] = [0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1]  # in the same place, turned alike
    equality.solref[:] = [CONTACT_TIME, 1.0]


def _add_robot(spec: mujoco.MjSpec, robot: Robot) -> None:
    base = spec.worldbody.add_body(name="base", mocap=True, pos=PARKED)
    described = mujoco.MjSpec.from_string(to_urdf(robot))
    described.compiler.fusestatic = False
    described.compiler.boundmass = described.compiler.boundinertia = LEAST_INERTIA
    spec.attach(described, frame=base.add_frame(), prefix=ROBOT)
    friction, radius = robot.gripper.pad
    for link in robot.links:
        body = spec.body(ROBOT + link.name)
        body.gravcomp = 1  # as the controllers of robots do
        for shape in body.geoms:
            shape.friction = [friction, 2 / 3 * friction * radius, 0.0]
            shape.priority = 1
            shape.contype, shape.conaffinity = 0, OBJECT_BIT | TABLE_BIT
            shape.condim = PAD_DIMENSIONS
            shape.solref[:2], shape.solimp = _CONTACT["solref"], _CONTACT["solimp"]
    for name, strength in robot.strength.items():
        spec.joint(ROBOT + name).armature = ARMATURE * strength
        _add_servo(
            spec, name, strength, strength / SLACK, DAMPING_TIME * strength / SLACK, HOLD + 2
        )
    force = robot.gripper.force
    stiffness = force / FINGER_SLACK
    for name in (LEFT, RIGHT):
        joint = spec.joint(ROBOT + name)
        joint.armature = 2 * TIME_STEP / SUBSTEPS * force / FINGER_SPEED
        joint.solref_limit[:2], joint.solimp_limit = _CONTACT["solref"], _CONTACT["solimp"]
        _add_servo(spec, name, force, stiffness, force / FINGER_SPEED, HOLD)
    for name in (LEFT, RIGHT):
        _add_servo(spec, name, force, 0.0, force / FINGER_SPEED, CLOSE)
    mirror = spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=ROBOT + LEFT,
        name2=ROBOT + RIGHT,
    )
    mirror.data[:2] = [0, 1]  # left = 0 + 1 * right
    mirror.solref[:] = [CONTACT_TIME, 1.0]
    mirror.solimp[:] = IMPEDANCE


def _add_servo(
    spec: mujoco.MjSpec, joint: str, strength: float, stiffness: float, damping: float, group: int
) -> None:
    """A motor that pulls a joint to a position, or without stiffness to a speed."""
    servo = spec.add_actuator(
        target=ROBOT + joint,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        forcelimited=True,
        forcerange=[-strength, strength],
        group=group,
    )
    servo.gainprm[0] = stiffness or damping
    servo.biasprm[1:3] = -stiffness, -damping
