"""The scene as Drake needs it: table, objects and robot, surfaces and motors."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pydrake import geometry
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody import plant as multibody
from pydrake.multibody import tree
from pydrake.systems.framework import Diagram, DiagramBuilder
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.friction import OBJECT, TABLE
from egad.sim.drives import LEFT, RIGHT, Follower
from egad.sim.model import Model
from egad.sim.robot import Box, HullShape, Joint, Robot, wall_boxes
from egad.sim.servos import SUBSTEPS, arm_servos, finger_servos
from egad.sim.world import TIME_STEP

STEP = TIME_STEP / SUBSTEPS
# Pressure in a soft body rises from 0 at its surface to this in its middle, pascals. Robot, table
# and walls are soft, and a single object is rigid: contacts are patches, whose size decides the
# torsion.
MODULUS = 3e7
# Pads with this modulus touch a ball of 25 mm at 20 N in a patch that resists twisting as much as a
# disc of this radius, pascals and metres.
PAD_MODULUS, PAD_RADIUS, MIN_RADIUS = 2e6, 0.005, 0.002
TABLE_SIZE = Box((12.0, 12.0, 0.2), (0.0, 0.0, -0.1))
RELAXATION_TIME = 0.005  # seconds, within which a penetration is undone
MIN_INERTIA = 1e-6  # kg and kg m2; links without mass are not allowed
PARKED = [0.0, 0.0, 100.0]  # where an unused robot waits
ONE_OBJECT_FRICTION = 10.0
MAX_FRICTION = 1.9  # of a contact, in multiples of that of the object
LINKAGE_STIFFNESS = 4e5  # N/m, of all joints of a finger together, at its pad
LINKAGE_DAMPING_TIME = 0.001  # seconds


class Scene(NamedTuple):
    """A compiled scene."""

    diagram: Diagram
    plant: multibody.MultibodyPlant
    objects: list[tree.RigidBody]
    walls: tree.RigidBody
    links: list[tree.RigidBody]  # of the robot
    walls_frame: tree.FixedOffsetFrame
    base: tree.FixedOffsetFrame  # where the root of the robot is


class Surfaces:
    """Surfaces of objects and of what they touch; the engine takes the harmonic mean of friction.

    An object's own number counts between objects. What they touch makes up for it.
    """

    def __init__(self, several: bool) -> None:
        """Choose the friction of objects, which nothing depends on if there is only one."""
        self._object, self._several = OBJECT.friction if several else ONE_OBJECT_FRICTION, several

    def of_object(self) -> geometry.ProximityProperties:
        """That of an object; if there are several, they are soft, or they would touch at points."""
        made = geometry.ProximityProperties()
        if self._several:
            geometry.AddCompliantHydroelasticProperties(1.0, MODULUS, made)
        else:
            geometry.AddRigidHydroelasticProperties(1.0, made)
        return _with_friction(made, self._object)

    def on_object(self, friction: float, modulus: float) -> geometry.ProximityProperties:
        """A soft surface whose contacts with an object have this friction."""
        made = geometry.ProximityProperties()
        geometry.AddCompliantHydroelasticProperties(1.0, modulus, made)
        capped = min(friction, MAX_FRICTION * self._object)
        return _with_friction(made, capped * self._object / (2 * self._object - capped))


def _with_friction(
    made: geometry.ProximityProperties, friction: float
) -> geometry.ProximityProperties:
    coulomb = multibody.CoulombFriction(friction, friction)
    geometry.AddContactMaterial(friction=coulomb, properties=made)
    made.AddProperty("material", "relaxation_time", RELAXATION_TIME)
    return made


def make_scene(
    models: Sequence[Model],
    robot: Robot | None,
    walls: float | None,
    factors: tuple[float, float],
) -> Scene:
    """Table, objects and robot with motors; factors of the objects' masses and its friction."""
    builder = DiagramBuilder()
    config = multibody.MultibodyPlantConfig(
        time_step=STEP,
        contact_model="hydroelastic",
        discrete_contact_approximation="sap",
        sap_near_rigid_threshold=0.0,  # otherwise pads sink in by millimetres
    )
    plant, graph = multibody.AddMultibodyPlant(config, builder)
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))  # it acts on objects only
    surfaces, world = Surfaces(len(models) > 1), plant.world_frame()
    side = surfaces.on_object(OBJECT.friction, MODULUS)
    ground = surfaces.on_object(TABLE.friction, MODULUS)
    _add_shapes(plant, plant.world_body(), [TABLE_SIZE], ground)
    around = plant.AddRigidBody("walls", _inertia(1.0, (1.0, 1.0, 1.0)))
    walls_frame = plant.AddFrame(tree.FixedOffsetFrame("around", world, RigidTransform()))
    plant.WeldFrames(walls_frame, around.body_frame())
    _add_shapes(plant, around, wall_boxes(walls) if walls else [], side)
    base = plant.AddFrame(tree.FixedOffsetFrame("base", world, RigidTransform(PARKED)))
    links = [] if robot is None else _add_robot(plant, robot, base, factors[1], surfaces)
    within = geometry.CollisionFilterDeclaration()
    within.ExcludeWithin(plant.CollectRegisteredGeometries(links))
    graph.collision_filter_manager().Apply(within)
    objects = []
    for number, model in enumerate(models):
        objects.append(plant.AddRigidBody(f"object{number}", object_inertia(model, factors[0])))
        parts = [HullShape(part.vertices) for part in model.parts]
        _add_shapes(plant, objects[-1], parts, surfaces.of_object())
        frame = objects[-1].body_frame()
        plant.AddJoint(tree.QuaternionFloatingJoint(f"object{number}", world, frame))
    plant.Finalize()
    return Scene(builder.Build(), plant, objects, around, links, walls_frame, base)


def object_inertia(model: Model, factor: float) -> tree.SpatialInertia:
    """Mass and inertia of an object, times a factor."""
    return _inertia(factor * model.mass, factor * model.inertia)


def _inertia(
    mass: float, moments: Sequence[float] | Floats, center: Sequence[float] = (0.0, 0.0, 0.0)
) -> tree.SpatialInertia:
    central = tree.RotationalInertia(*moments)
    return tree.SpatialInertia.MakeFromCentralInertia(mass, list(center), central)


def _add_robot(
    plant: multibody.MultibodyPlant,
    robot: Robot,
    base: tree.FixedOffsetFrame,
    factor: float,
    surfaces: Surfaces,
) -> list[tree.RigidBody]:
    """The links of a robot, with the friction of its pads times a factor."""
    friction, radius = robot.gripper.pad
    modulus = PAD_MODULUS * (PAD_RADIUS / max(radius, MIN_RADIUS)) ** 4
    surface = surfaces.on_object(factor * friction, modulus)
    joints = {joint.child: joint for joint in robot.joints}
    links = []
    for link in robot.links:
        moments = np.maximum(link.moments, MIN_INERTIA)
        inertia = _inertia(max(link.mass, MIN_INERTIA), moments, link.box.center)
        links.append(plant.AddRigidBody(link.name, inertia))
        _add_shapes(plant, links[-1], link.shapes, surface)
        if link.name in joints:
            plant.AddJoint(_joint(plant, joints[link.name]))
        else:
            plant.WeldFrames(base, links[-1].body_frame())
    for servo in [*arm_servos(robot), *finger_servos(robot)]:
        motor = plant.AddJointActuator(
            servo.joint, plant.GetJointByName(servo.joint), servo.strength
        )
        motor.set_controller_gains(tree.PdControllerGains(p=servo.stiffness, d=servo.damping))
        motor.set_default_rotor_inertia(servo.armature)
    for follower in robot.followers:
        stiffness = linkage_stiffness(robot, follower)
        motor = plant.AddJointActuator(follower.joint, plant.GetJointByName(follower.joint))
        damping = LINKAGE_DAMPING_TIME * stiffness
        motor.set_controller_gains(tree.PdControllerGains(p=stiffness, d=damping))
    if robot.drive.joints and robot.drive.mirrored:
        plant.AddCouplerConstraint(plant.GetJointByName(LEFT), plant.GetJointByName(RIGHT), 1.0)
    return links


def linkage_stiffness(robot: Robot, follower: Follower) -> float:
    """Stiffness with which a joint follows its finger, N/m or N m."""
    slope = np.ptp(follower.positions) / np.ptp(follower.distances)
    beside = sum(each.side == follower.side for each in robot.followers)
    return float(LINKAGE_STIFFNESS / beside / slope**2)


def _joint(
    plant: multibody.MultibodyPlant, joint: Joint
) -> tree.WeldJoint | tree.PrismaticJoint | tree.RevoluteJoint:
    turn = RotationMatrix(Rotation.from_rotvec(joint.turn).as_matrix())
    parent, child = plant.GetFrameByName(joint.parent), plant.GetFrameByName(joint.child)
    place = RigidTransform(turn, list(joint.origin))
    if joint.kind == "fixed":
        return tree.WeldJoint(joint.child, parent, child, place)
    frame = plant.AddFrame(tree.FixedOffsetFrame(f"{joint.child}-joint", parent, place))
    kind = tree.PrismaticJoint if joint.kind == "prismatic" else tree.RevoluteJoint
    return kind(joint.child, frame, child, list(joint.axis), *joint.limits)


def _add_shapes(
    plant: multibody.MultibodyPlant,
    body: tree.RigidBody,
    shapes: Sequence[Box | HullShape],
    surface: geometry.ProximityProperties,
) -> None:
    for number, shape in enumerate(shapes):
        if isinstance(shape, Box):
            solid, place = geometry.Box(*shape.size), RigidTransform(list(shape.center))
        else:
            solid, place = geometry.Convex(shape.points.T, "hull"), RigidTransform()
        plant.RegisterCollisionGeometry(body, place, solid, f"shape{number}", surface)
