"""The scene as Drake needs it: table, objects and robot, surfaces and motors."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    CollisionFilterDeclaration,
    Convex,
    ProximityProperties,
    SceneGraph,
    Shape,
)
from pydrake.geometry import Box as BoxShape
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    PdControllerGains,
    PrismaticJoint,
    QuaternionFloatingJoint,
    RevoluteJoint,
    RigidBody,
    RotationalInertia,
    SpatialInertia,
    WeldJoint,
)
from pydrake.systems.framework import Diagram, DiagramBuilder
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.friction import OBJECT, TABLE
from egad.sim.drives import LEFT, RIGHT, Follower
from egad.sim.model import Model
from egad.sim.robot import PALM, Box, Joint, Link, Robot, wall_boxes
from egad.sim.servos import SUBSTEPS, arm_servos, finger_servos
from egad.sim.world import TIME_STEP

STEP = TIME_STEP / SUBSTEPS
# Pressure in a soft body rises from 0 at its surface to this in its middle, pascals. Objects are
# rigid, robot, table and walls are soft: contacts are patches, whose size decides the torsion.
MODULUS = 3e7
TABLE_SIZE = Box((12.0, 12.0, 0.2), (0.0, 0.0, -0.1))  # metres
RELAXATION_TIME = 0.005  # seconds, within which a penetration is undone
POINT_STIFFNESS = 1e5  # N/m, between objects, which touch at points
MIN_INERTIA = 1e-6  # kg and kg m2; links without mass are not allowed
PARKED = (0.0, 0.0, 100.0)  # where an unused robot waits
ONE_OBJECT_FRICTION = 10.0
MAX_FRICTION = 1.9  # of a contact, in multiples of that of the object
LINKAGE_STIFFNESS = 1e5  # N/m, of all joints of a linkage together, at the pad
LINKAGE_DAMPING_TIME = 0.005  # seconds


class Held(NamedTuple):
    """An object in the hand: its number, and its pose in the frame of the palm, (4, 4)."""

    number: int
    pose: Floats


class Scene(NamedTuple):
    """A compiled scene."""

    diagram: Diagram
    plant: MultibodyPlant
    graph: SceneGraph
    objects: list[RigidBody]
    walls: list[RigidBody]
    links: list[RigidBody]
    base: FixedOffsetFrame | None  # frame of the robot's root


class Surfaces:
    """Surfaces in contact with objects, whose own friction only other objects and walls feel."""

    def __init__(self, several: bool) -> None:
        """Choose the friction of objects, which matters only if there are several."""
        self._object, self._several = OBJECT.friction if several else ONE_OBJECT_FRICTION, several

    def of_object(self) -> ProximityProperties:
        """That of an object."""
        made = ProximityProperties()
        if self._several:  # two rigid ones would touch at one point of each pair of parts
            AddCompliantHydroelasticProperties(1.0, MODULUS, made)
        else:
            AddRigidHydroelasticProperties(1.0, made)
        return _with_friction(made, self._object)

    def against_object(self, friction: float) -> ProximityProperties:
        """A surface whose contacts with an object have this friction."""
        made = ProximityProperties()
        AddCompliantHydroelasticProperties(1.0, MODULUS, made)
        # The engine takes the harmonic mean of both.
        capped = min(friction, MAX_FRICTION * self._object)
        return _with_friction(made, capped * self._object / (2 * self._object - capped))


def _with_friction(made: ProximityProperties, friction: float) -> ProximityProperties:
    coulomb = CoulombFriction(friction, friction)
    AddContactMaterial(point_stiffness=POINT_STIFFNESS, friction=coulomb, properties=made)
    made.AddProperty("material", "relaxation_time", RELAXATION_TIME)
    return made


def make_scene(
    models: Sequence[Model],
    robot: Robot | None,
    walls: float | None,
    mass_factor: float,
    friction_factor: float,
    held: Held | None,
) -> Scene:
    """Table, objects, one of which the palm may hold, and robot with motors."""
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(
        time_step=STEP,
        contact_model="hydroelastic_with_fallback",
        discrete_contact_approximation="sap",
        sap_near_rigid_threshold=0.0,  # otherwise pads sink in by millimetres
    )
    plant, graph = AddMultibodyPlant(config, builder)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])  # it acts on objects only
    surfaces = Surfaces(len(models) > 1)
    world = plant.world_body()
    _add_box(plant, world, TABLE_SIZE, surfaces.against_object(TABLE.friction))
    side = surfaces.against_object(OBJECT.friction)
    boxes = []
    for number, box in enumerate(wall_boxes(walls) if walls else []):
        boxes.append(plant.AddRigidBody(f"wall{number}", _inertia(1.0, (1.0, 1.0, 1.0))))
        plant.WeldFrames(plant.world_frame(), boxes[-1].body_frame())
        _add_box(plant, boxes[-1], box, side)
    objects = [
        _add_object(plant, model, number, mass_factor, surfaces.of_object())
        for number, model in enumerate(models)
    ]
    links: list[RigidBody] = []
    base = None
    if robot is not None:
        pad = surfaces.against_object(friction_factor * robot.gripper.pad.friction)
        place = RigidTransform(list(PARKED))
        base = plant.AddFrame(FixedOffsetFrame("base", plant.world_frame(), place))
        links = _add_robot(plant, robot, base, pad)
        within = CollisionFilterDeclaration().ExcludeWithin(plant.CollectRegisteredGeometries(links))
        graph.collision_filter_manager().Apply(within)
    for number, body in enumerate(objects):
        if held is not None and held.number == number:
            palm = plant.GetFrameByName(PALM)
            weld = WeldJoint("held", palm, body.body_frame(), RigidTransform(held.pose))
            plant.AddJoint(weld)
        else:
            name = f"object{number}"
            free = QuaternionFloatingJoint(name, plant.world_frame(), body.body_frame())
            plant.AddJoint(free)
    plant.Finalize()
    return Scene(builder.Build(), plant, graph, objects, boxes, links, base)


def _add_object(
    plant: MultibodyPlant, model: Model, number: int, factor: float, surface: ProximityProperties
) -> RigidBody:
    body = plant.AddRigidBody(f"object{number}", object_inertia(model, factor))
    for part in model.parts:
        _add_shape(plant, body, Convex(part.vertices.T, "part"), surface)
    return body


def object_inertia(model: Model, factor: float) -> SpatialInertia:
    """Mass and inertia of an object, times a factor."""
    central = RotationalInertia(*(factor * model.inertia))
    return SpatialInertia.MakeFromCentralInertia(factor * model.mass, np.zeros(3), central)


def _add_robot(
    plant: MultibodyPlant, robot: Robot, base: FixedOffsetFrame, surface: ProximityProperties
) -> list[RigidBody]:
    joints = {joint.child: joint for joint in robot.joints}
    links: dict[str, RigidBody] = {}
    for link in robot.links:
        links[link.name] = body = _add_link(plant, link, surface)
        if link.name in joints:
            joint = joints[link.name]
            plant.AddJoint(_joint(joint, links[joint.parent]))
        else:
            plant.WeldFrames(base, body.body_frame())
    for servo in [*arm_servos(robot), *finger_servos(robot)]:
        name, strength, stiffness, damping, armature = servo
        motor = plant.AddJointActuator(name, plant.GetJointByName(name), strength)
        motor.set_controller_gains(PdControllerGains(p=stiffness, d=damping))
        motor.set_default_rotor_inertia(armature)
    for follower in robot.followers:
        stiffness = linkage_stiffness(robot, follower)
        motor = plant.AddJointActuator(follower.joint, plant.GetJointByName(follower.joint))
        gains = PdControllerGains(p=stiffness, d=LINKAGE_DAMPING_TIME * stiffness)
        motor.set_controller_gains(gains)
    if robot.drive.joints and robot.drive.mirrored:
        plant.AddCouplerConstraint(plant.GetJointByName(LEFT), plant.GetJointByName(RIGHT), 1.0)
    return list(links.values())


def linkage_stiffness(robot: Robot, follower: Follower) -> float:
    """Stiffness with which a joint follows its finger, N/m or N m."""
    slope = np.ptp(follower.positions) / np.ptp(follower.distances)
    return float(LINKAGE_STIFFNESS / len(robot.followers) / slope**2)


def _add_link(plant: MultibodyPlant, link: Link, surface: ProximityProperties) -> RigidBody:
    body = plant.AddRigidBody(link.name, _inertia(link.mass, link.moments, link.box.center))
    for shape in link.shapes:
        if isinstance(shape, Box):
            _add_box(plant, body, shape, surface)
        else:
            _add_shape(plant, body, Convex(shape.points.T, "link"), surface)
    return body


def _joint(joint: Joint, parent: RigidBody) -> WeldJoint | PrismaticJoint | RevoluteJoint:
    """The joint, except for its child, which has its name."""
    turn = RotationMatrix(Rotation.from_rotvec(joint.turn).as_matrix())
    plant = parent.GetParentPlant()
    child, place = plant.GetFrameByName(joint.child), RigidTransform(turn, list(joint.origin))
    if joint.kind == "fixed":
        return WeldJoint(joint.child, parent.body_frame(), child, place)
    frame = FixedOffsetFrame(f"{joint.child}-joint", parent.body_frame(), place)
    kind = PrismaticJoint if joint.kind == "prismatic" else RevoluteJoint
    return kind(joint.child, plant.AddFrame(frame), child, list(joint.axis), *joint.limits)


def _add_box(
    plant: MultibodyPlant, body: RigidBody, box: Box, surface: ProximityProperties
) -> None:
    _add_shape(plant, body, BoxShape(*box.size), surface, RigidTransform(list(box.center)))


def _add_shape(
    plant: MultibodyPlant,
    body: RigidBody,
    shape: Shape,
    surface: ProximityProperties,
    place: RigidTransform | None = None,
) -> None:
    name = f"shape{len(plant.GetCollisionGeometriesForBody(body))}"
    plant.RegisterCollisionGeometry(body, place or RigidTransform(), shape, name, surface)


def _inertia(
    mass: float, moments: Sequence[float], center: Sequence[float] = (0.0, 0.0, 0.0)
) -> SpatialInertia:
    least = np.maximum(moments, MIN_INERTIA)
    central = RotationalInertia(*least)
    return SpatialInertia.MakeFromCentralInertia(max(mass, MIN_INERTIA), list(center), central)
