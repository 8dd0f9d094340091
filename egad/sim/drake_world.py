"""The simulated world in Drake, whose contacts are patches between soft and rigid surfaces."""

from collections.abc import Sequence
from typing import Self

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import CollisionFilterDeclaration, GeometrySet
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context
from typing_extensions import override

from egad._util.arrays import Floats
from egad.friction import TABLE_ROLLING
from egad.sim.drake_model import STEP, Held, make_scene, object_inertia
from egad.sim.drake_motors import Motors
from egad.sim.servos import SUBSTEPS
from egad.sim.world import (
    DOWN,
    FINGERS,
    FIRST_OBJECT,
    OTHERS,
    TABLE,
    TIME_STEP,
    WALLS,
    Forces,
    Pose,
    UnstableError,
    World,
)

PIN_FACTOR = 1e4  # of the mass of an object that is held in place


class DrakeWorld(World):
    """A world in Drake: the compiled `scene`, and the state of its bodies, `context`."""

    def __enter__(self) -> Self:
        self._build(None)
        self.reset()
        return self

    def __exit__(self, *_: object) -> None:
        del self._simulator, self.scene, self.context

    def _build(self, held: Held | None) -> None:
        """Compile the scene with the current factors."""
        self._factors, self._held = (self.mass_factor, self.friction_factor), held
        self.scene = make_scene(self.models, self.robot, self.walls, self._factors, held)
        plant, robot = self.scene.plant, self.robot
        self._simulator = Simulator(self.scene.diagram)
        sides = {} if robot is None else robot.sides
        bodies = [
            (TABLE, plant.world_body()),
            *((WALLS, body) for body in self.scene.walls),
            *((FINGERS.get(sides.get(link.name(), ""), OTHERS), link) for link in self.scene.links),
            *enumerate(self.scene.objects, FIRST_OBJECT),
        ]
        self._owners = {
            shape: owner
            for owner, body in bodies
            for shape in plant.GetCollisionGeometriesForBody(body)
        }
        if robot is not None:
            self._motors = Motors(plant, robot)
        self._start()

    def _start(self) -> None:
        """Return to the initial state of the compiled scene."""
        self._simulator.reset_context(self.scene.diagram.CreateDefaultContext())
        root = self._simulator.get_mutable_context()
        self.context = self.scene.plant.GetMyMutableContextFromRoot(root)
        self._ticks, self._walled = 0, True
        self._sums: Floats | None = None
        self._pinned: dict[int, Pose] = {}

    @override
    def reset(self) -> None:
        if (self.mass_factor, self.friction_factor) != self._factors or self._held is not None:
            self._build(None)
        self._start()
        self.set_gravity(DOWN)
        self._here, self.attached = False, None
        if self.robot is not None:
            # not locked where it is parked: the engine crashes if joints with motors are
            middles = {joint.child: sum(joint.limits) / 2 for joint in self.robot.joints}
            self._motors.place(self.context, [middles[name] for name in self.robot.arm], 0.0)
        self._place_objects()

    @override
    def set_gravity(self, acceleration: Sequence[float]) -> None:
        self._gravity = np.array(acceleration)

    @override
    def place(
        self,
        pose: Pose,
        velocity: Sequence[float] = (0.0, 0.0, 0.0),
        turning: Sequence[float] = (0.0, 0.0, 0.0),
        number: int = 0,
    ) -> None:
        joint = self.scene.plant.GetJointByName(f"object{number}")
        self._unpin(number)
        joint.SetPose(self.context, _transform(pose))
        joint.set_translational_velocity(self.context, velocity)
        joint.set_angular_velocity(self.context, turning)

    @override
    def remove_walls(self) -> None:
        graph = self.scene.graph
        context = graph.GetMyMutableContextFromRoot(self._simulator.get_mutable_context())
        walls = GeometrySet([s for s, owner in self._owners.items() if owner == WALLS])
        others = GeometrySet([s for s, owner in self._owners.items() if owner != WALLS])
        rule = CollisionFilterDeclaration().ExcludeBetween(walls, others)
        graph.collision_filter_manager(context).Apply(rule)
        self._walled = False

    @override
    def put_robot(self, base: Pose, joints: Sequence[float], opening: float) -> None:
        self.scene.base.SetPoseInParentFrame(self.context, _transform(base))
        self._motors.place(self.context, joints, opening)
        self._here = True

    @override
    def drive(self, joints: Sequence[float], speeds: Sequence[float]) -> None:
        arm = self._motors.arm
        self._motors.targets[arm], self._motors.speeds[arm] = joints, speeds

    @override
    def close_fingers(self) -> None:
        self._motors.closing = True

    @override
    def arm_joints(self) -> Floats:
        return self._motors.state(self.context, self._motors.arm)[0]

    @override
    def fingers(self) -> tuple[Floats, Floats]:
        state = self._motors.state(self.context, self._motors.fingers)
        return self.known_robot.drive.pads(*state)

    @override
    def forces(self, number: int | None = None) -> Forces:
        return Forces.between(self._contact_forces(), number)

    def _contact_forces(self) -> Floats:
        """Forces between all owners in the last step; those of the table are normal to it.

        The others include friction, so they are up to a quarter higher than normal forces.
        """
        if self._sums is None:
            self._sums = np.zeros((FIRST_OBJECT + len(self.models),) * 2)
            contacts = self.scene.plant.get_contact_results_output_port().Eval(self.context)
            for index in range(contacts.num_hydroelastic_contacts() if self._ticks else 0):
                contact = contacts.hydroelastic_contact_info(index)
                surface = contact.contact_surface()
                pair = sorted((self._owners[surface.id_M()], self._owners[surface.id_N()]))
                force = contact.F_Ac_W().translational()
                size = abs(force[2]) if pair[0] == TABLE else np.linalg.norm(force)
                self._sums[tuple(pair)] += size
        return self._sums

    @override
    def link_poses(self) -> list[Pose]:
        return [self._pose(link) for link in self.scene.links] if self._here else []

    @override
    def speeds(self) -> tuple[float, float]:
        velocities = [self._velocity(body) for body in self.scene.objects]
        linear, angular = np.linalg.norm(velocities, axis=2).max(axis=0).tolist()
        return linear, angular

    def _pose(self, body: RigidBody) -> Pose:
        place = self.scene.plant.EvalBodyPoseInWorld(self.context, body)
        turn = place.rotation().ToQuaternion().wxyz()
        return Pose(place.translation(), np.roll(turn, -1))

    def _velocity(self, body: RigidBody) -> tuple[Floats, Floats]:
        speed = self.scene.plant.EvalBodySpatialVelocityInWorld(self.context, body)
        return speed.translational(), speed.rotational()

    def _numbers(self, number: int) -> tuple[Sequence[float], Sequence[float]]:
        position, quaternion = self._pose(self.scene.objects[number])
        return position.tolist(), quaternion.tolist()

    def _advance(self) -> float:
        pulls = []
        try:
            self._apply_weights()
            for _ in range(SUBSTEPS):
                if self.robot is not None:
                    self._motors.apply(self.context)
                self._ticks += 1
                self._simulator.AdvanceTo(self._ticks * STEP)
                if self._held is not None:
                    pulls.append(self._pull_now(self._held.number))
        except (RuntimeError, SystemExit) as error:  # the latter after failed assertions
            raise UnstableError(str(error)) from error
        self._sums = None
        self._mean_pull = np.mean(pulls, axis=0) if pulls else np.zeros((2, 3))
        return self.speeds()[0]

    def _apply_weights(self) -> None:
        """Apply gravity, and the torque with which the table resists rolling."""
        wrenches = []
        for number, (model, body) in enumerate(zip(self.models, self.scene.objects, strict=True)):
            if number in self._pinned:
                continue
            _, turning = self._velocity(body)
            speed, support = float(np.linalg.norm(turning)), self.forces(number).support
            # no more than would stop the object in this step
            most = self.mass_factor * model.inertia.min() * speed / (2 * TIME_STEP)
            torque = min(TABLE_ROLLING * support, most) / max(speed, 1e-12)
            force = self.mass_factor * model.mass * self._gravity
            wrench = ExternallyAppliedSpatialForce()
            wrench.body_index = body.index()
            wrench.p_BoBq_B = np.zeros(3)
            wrench.F_Bq_W = SpatialForce(-torque * turning, force)
            wrenches.append(wrench)
        port = self.scene.plant.get_applied_spatial_force_input_port()
        port.FixValue(self.context, wrenches)

    def _attach(self, pose: Floats, number: int) -> None:
        self._rebuild(Held(number, pose))

    def _detach(self, number: int) -> None:
        place, velocity = self.pose(number), self._velocity(self.scene.objects[number])
        self._rebuild(None)
        self.place(place, *velocity, number=number)

    def _rebuild(self, held: Held | None) -> None:
        """Weld an object to the palm, or release it, and go on from the current state."""
        scene, context, motors = self.scene, self.context, self._motors
        walled, pinned = self._walled, self._pinned
        self._build(held)
        self._motors.resume(motors)
        place = scene.base.GetPoseInParentFrame(context)
        self.scene.base.SetPoseInParentFrame(self.context, place)
        _copy_state(scene.plant, context, self.scene.plant, self.context)
        for number, pose in pinned.items():
            self._pin(pose, number)
        if not walled:
            self.remove_walls()

    def _pull(self, number: int) -> Floats:
        del number
        return self._mean_pull

    def _pull_now(self, number: int) -> Floats:
        """Same as `_pull`, but for the last of the engine's own steps."""
        plant = self.scene.plant
        weld = plant.GetJointByName("held").index()
        pull = plant.get_reaction_forces_output_port().Eval(self.context)[int(weld)]
        turn = self._pose(self.scene.objects[number]).matrix[:3, :3]
        return np.stack([turn @ pull.translational(), turn @ pull.rotational()])

    def _pin(self, pose: Pose, number: int) -> None:
        # heavy and without weight; the engine crashes if joints are locked
        self.place(pose, number=number)
        self._pinned[number] = pose
        self._weigh(number, PIN_FACTOR)

    def _unpin(self, number: int) -> None:
        if self._pinned.pop(number, None) is not None:
            self._weigh(number, 1.0)

    def _weigh(self, number: int, factor: float) -> None:
        """Give an object a multiple of its mass."""
        inertia = object_inertia(self.models[number], factor * self.mass_factor)
        self.scene.objects[number].SetSpatialInertiaInBodyFrame(self.context, inertia)


def _copy_state(before: MultibodyPlant, old: Context, after: MultibodyPlant, new: Context) -> None:
    """Copy the state of the joints that two plants have in common."""
    for what in ("Positions", "Velocities"):
        read, write = getattr(MultibodyPlant, f"Get{what}"), getattr(MultibodyPlant, f"Set{what}")
        names = getattr(MultibodyPlant, f"Get{what.replace('ies', 'y').rstrip('s')}Names")
        known = dict(zip(names(before), read(before, old), strict=True))
        values = zip(names(after), read(after, new), strict=True)
        write(after, new, [known.get(name, value) for name, value in values])


def _transform(pose: Pose) -> RigidTransform:
    turn = np.roll(pose.quaternion, 1)
    return RigidTransform(Quaternion(turn / np.linalg.norm(turn)), pose.position)
