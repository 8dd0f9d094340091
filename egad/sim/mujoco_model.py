"""The scene as MuJoCo needs it: table, objects and robot, contacts and motors."""

from collections.abc import Sequence

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from egad import friction
from egad._util.arrays import Floats
from egad.friction import TABLE_ROLLING, Surface
from egad.sim.drives import LEFT, RIGHT
from egad.sim.model import Model
from egad.sim.robot import EFFORT, PALM, Box, HullShape, Joint, Link, Robot, wall_boxes
from egad.sim.servos import SUBSTEPS, Servo, arm_servos, finger_servos
from egad.sim.world import TIME_STEP

# Contacts are soft: the stiffest that the step allows, and close to rigid.
CONTACT_TIME = 2 * TIME_STEP / SUBSTEPS  # seconds, within which a penetration is undone
IMPEDANCE = (0.99, 0.995, 0.0005, 0.5, 2.0)
FRICTION_STIFFNESS = 100.0  # of friction against normal forces, or held objects creep
MIN_INERTIA = 1e-6  # kg and kg m2; links without mass are not allowed
FOLLOWER_ARMATURE = 1e-5  # kg or kg m2
PARKED = (0.0, 0.0, 100.0)  # where an unused robot waits
ROBOT = "robot-"  # prefix of the names of its links and joints
KINDS = {"prismatic": mujoco.mjtJoint.mjJNT_SLIDE, "revolute": mujoco.mjtJoint.mjJNT_HINGE}
HOLD, CLOSE, ARM = range(3)  # groups of actuators: of the fingers, and of the arm
OBJECT, WALL = "object", "wall"  # prefixes of their numbers
# Collision bits: objects collide with everything, table and robot also with each other.
OBJECT_BIT, TABLE_BIT = 1, 2
CONTACT_DIMENSIONS, PAD_DIMENSIONS = 6, 4  # with torsion, that of the table with rolling, too
ON_TABLE, ON_OBJECT = (
    [each.friction, TABLE_ROLLING, TABLE_ROLLING] for each in (friction.TABLE, friction.OBJECT)
)
_CONTACT = {"condim": CONTACT_DIMENSIONS, "solref": [CONTACT_TIME, 1.0], "solimp": list(IMPEDANCE)}


def scene_spec(
    models: Sequence[Model], robot: Robot | None, walls: float | None = None
) -> mujoco.MjSpec:
    """Table, objects and robot with motors; welds hold objects, then as many to a cup."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    option = spec.option
    option.timestep = TIME_STEP / SUBSTEPS
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = FRICTION_STIFFNESS
    option.disableflags = mujoco.mjtDisableBit.mjDSBL_AUTORESET  # explosions must be detected
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[1, 1, 1],
        friction=ON_TABLE,
        priority=1,
        contype=TABLE_BIT,
        conaffinity=OBJECT_BIT,
        **_CONTACT,
    )
    for number, box in enumerate(wall_boxes(walls) if walls else []):
        spec.worldbody.add_geom(
            name=f"{WALL}{number}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[side / 2 for side in box.size],
            pos=box.center,
            friction=ON_OBJECT,
            contype=TABLE_BIT,
            conaffinity=OBJECT_BIT,
            **_CONTACT,
        )
    for number, model in enumerate(models):
        _add_object(spec, model, number)
    if robot is not None:
        _add_robot(spec, robot)
        if robot.drive.welds:
            for number in range(len(models)):
                _add_weld(spec, ROBOT + PALM, f"{OBJECT}{number}").solimp[:] = IMPEDANCE
    return spec


def _add_object(spec: mujoco.MjSpec, model: Model, order: int) -> None:
    body = spec.worldbody.add_body(name=f"{OBJECT}{order}")
    body.add_freejoint()
    body.explicitinertial = True
    body.mass, body.inertia = model.mass, model.inertia
    for number, part in enumerate(model.parts):
        name = f"part{order}-{number}"
        spec.add_mesh(
            name=name,
            uservert=part.vertices.ravel(),
            userface=part.faces.ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
        )
        # Table and robot have a higher priority: their friction counts, not the object's.
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=name,
            mass=0,
            friction=ON_OBJECT,
            contype=OBJECT_BIT,
            conaffinity=OBJECT_BIT,
            **_CONTACT,
        )
    pin = spec.worldbody.add_body(name=f"pin{order}", mocap=True)
    _add_weld(spec, pin.name, body.name)


def _add_weld(spec: mujoco.MjSpec, first: str, second: str) -> mujoco.MjsEquality:
    """A constraint that can hold two bodies at the same position and orientation."""
    equality = spec.add_equality(
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=first,
        name2=second,
        active=False,
    )
    equality.data[:11] = [0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1]
    equality.solref[:] = [CONTACT_TIME, 1.0]
    return equality


def _add_robot(spec: mujoco.MjSpec, robot: Robot) -> None:
    base = spec.worldbody.add_body(name="base", mocap=True, pos=PARKED)
    joints = {joint.child: joint for joint in robot.joints}
    bodies: dict[str, mujoco.MjsBody] = {}
    for link in robot.links:
        joint = joints.get(link.name)
        parent = base if joint is None else bodies[joint.parent]
        bodies[link.name] = _add_link(parent, link, joint)
        _add_shapes(spec, bodies[link.name], link, robot.gripper.pad)
    for follower in robot.followers:
        spec.joint(ROBOT + follower.joint).armature = FOLLOWER_ARMATURE
        _couple(spec, follower.joint, follower.side, follower.polynomial())
    for servo in arm_servos(robot):
        _add_servo(spec, servo, ARM)
    fingers = finger_servos(robot)
    for servo in fingers:
        driven = spec.joint(ROBOT + servo.joint)
        driven.solref_limit[:2], driven.solimp_limit = _CONTACT["solref"], _CONTACT["solimp"]
        _add_servo(spec, servo, HOLD)
    for servo in fingers:
        _add_servo(spec, servo._replace(stiffness=0.0), CLOSE)
    if robot.drive.joints and robot.drive.mirrored:
        _couple(spec, LEFT, RIGHT, [0.0, 1.0])


def _add_link(parent: mujoco.MjsBody, link: Link, joint: Joint | None) -> mujoco.MjsBody:
    """Add the body of a link without its shapes, and its joint on another one."""
    body = parent.add_body(name=ROBOT + link.name, explicitinertial=True)
    body.gravcomp = 1  # as the controllers of robots do
    body.mass, body.ipos = max(link.mass, MIN_INERTIA), link.box.center
    body.fullinertia[:3] = np.maximum(link.moments, MIN_INERTIA)
    body.fullinertia[3:] = 0
    if joint is None:
        return body
    angles = Rotation.from_rotvec(joint.turn).as_euler("xyz")
    mujoco.mju_euler2Quat(turn := np.empty(4), angles, "XYZ")  # about fixed axes
    body.pos, body.quat = joint.origin, turn
    if joint.kind != "fixed":
        body.add_joint(
            name=ROBOT + joint.child,
            type=KINDS[joint.kind],
            axis=joint.axis,
            range=joint.limits,
            actfrcrange=[-EFFORT, EFFORT],
        )
    return body


def _add_shapes(spec: mujoco.MjSpec, body: mujoco.MjsBody, link: Link, pad: Surface) -> None:
    """Give a link its shapes, boxes first, with the friction of the pads."""
    for box in (each for each in link.shapes if isinstance(each, Box)):
        half = [side / 2 for side in box.size]
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, pos=box.center, size=half)
    for number, shape in enumerate(link.shapes):
        if isinstance(shape, HullShape):
            name = f"{link.name}-{number}"
            spec.add_mesh(
                name=name,
                uservert=shape.points.ravel(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
            )
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, mass=0)
    for geom in body.geoms:
        geom.friction = [pad.friction, pad.torsion, 0.0]
        geom.priority = 1
        geom.contype, geom.conaffinity = 0, OBJECT_BIT | TABLE_BIT
        geom.condim = PAD_DIMENSIONS
        geom.solref[:2], geom.solimp = _CONTACT["solref"], _CONTACT["solimp"]


def _couple(
    spec: mujoco.MjSpec, joint: str, leader: str, coefficients: Sequence[float] | Floats
) -> None:
    """Make a joint of the robot a polynomial of another one, constant term first."""
    gear = spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=ROBOT + joint,
        name2=ROBOT + leader,
    )
    gear.data[: len(coefficients)] = coefficients
    gear.solref[:] = [CONTACT_TIME, 1.0]
    gear.solimp[:] = IMPEDANCE


def _add_servo(spec: mujoco.MjSpec, servo: Servo, group: int) -> None:
    """Add a motor that drives a joint to a position or, without stiffness, to a speed."""
    name, strength, stiffness, damping, armature = servo
    spec.joint(ROBOT + name).armature = armature
    motor = spec.add_actuator(
        target=ROBOT + name,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        forcelimited=True,
        forcerange=[-strength, strength],
        group=group,
    )
    motor.gainprm[0] = stiffness or damping
    motor.biasprm[1:3] = -stiffness, -damping
