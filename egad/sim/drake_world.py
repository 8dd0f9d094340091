"""The simulated world in Drake, whose contacts are patches between soft and rigid surfaces."""

from collections.abc import Sequence
from typing import Self

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.multibody.tree import RigidBody
from pydrake.systems.analysis import Simulator
from scipy.spatial.transform import Rotation
from typing_extensions import override

from egad._util.arrays import Floats
from egad.friction import TABLE_ROLLING
from egad.sim.drake_model import STEP, make_scene, object_inertia
from egad.sim.drake_motors import Motors
from egad.sim.robot import PALM
from egad.sim.servos import SUBSTEPS
from egad.sim.world import (
    DOWN,
    FINGERS,
    FIRST_OBJECT,
    OTHERS,
    TABLE,
    WALLS,
    Forces,
    Pose,
    UnstableError,
    World,
)

AWAY = [0.0, 0.0, -10.0]  # where removed walls are, metres
PIN_FACTOR = 1e4  # of the mass of an object that is held in place


class DrakeWorld(World):
    """A world in Drake: the compiled `scene`, and the state of its bodies, `context`."""

    def __enter__(self) -> Self:
        self._build()
        self.reset()
        return self

    def __exit__(self, *_: object) -> None:
        del self._simulator, self.scene, self.context

    def _build(self) -> None:
        """Compile the scene with the current factors."""
        self._factors = self.mass_factor, self.friction_factor
        self.scene = make_scene(self.models, self.robot, self.walls, self._factors)
        plant, robot = self.scene.plant, self.robot
        self._simulator = Simulator(self.scene.diagram)
        sides = {} if robot is None else robot.sides
        bodies = [
            (TABLE, plant.world_body()),
            (WALLS, self.scene.walls),
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

    @override
    def reset(self) -> None:
        if (self.mass_factor, self.friction_factor) != self._factors:
            self._build()
        self._simulator.reset_context(self.scene.diagram.CreateDefaultContext())
        root = self._simulator.get_mutable_context()
        self.context = self.scene.plant.GetMyMutableContextFromRoot(root)
        self._ticks = 0
        self._sums: Floats | None = None
        self._pinned: set[int] = set()
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
        self.scene.walls_frame.SetPoseInParentFrame(self.context, RigidTransform(AWAY))

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
        self._pulls: list[Floats] = []
        try:
            for _ in range(SUBSTEPS):
                self._apply_forces()
                if self.robot is not None:
                    self._motors.apply(self.context)
                self._ticks += 1
                self._simulator.AdvanceTo(self._ticks * STEP)
                self._sums = None
        except (RuntimeError, SystemExit) as error:  # the latter after failed assertions
            raise UnstableError(str(error)) from error
        return self.speeds()[0]

    def _apply_forces(self) -> None:
        """Apply gravity, the torque with which the table resists rolling, and the pull of a cup."""
        wrenches = []
        for number, (model, body) in enumerate(zip(self.models, self.scene.objects, strict=True)):
            if number in self._pinned:
                continue
            _, turning = self._velocity(body)
            speed, support = float(np.linalg.norm(turning)), self.forces(number).support
            # much less than would stop the object in this step
            most = self.mass_factor * model.inertia.min() * speed / (4 * STEP)
            torque = min(TABLE_ROLLING * support, most) / max(speed, 1e-12)
            weight = self.mass_factor * model.mass * self._gravity
            wrenches.append(_wrench(body, -torque * turning, weight))
        if self.attached is not None:
            force, torque = self._follow_palm(self.attached)
            self._pulls.append(np.stack([force, torque]))
            palm, body = self._palm, self.scene.objects[self.attached]
            lever = self._pose(body).position - self._pose(palm).position
            wrenches.append(_wrench(body, torque, force))
            wrenches.append(_wrench(palm, -torque - np.cross(lever, force), -force))
        port = self.scene.plant.get_applied_spatial_force_input_port()
        port.FixValue(self.context, wrenches)

    @property
    def _palm(self) -> RigidBody:
        palm: RigidBody = self.scene.plant.GetBodyByName(PALM)
        return palm

    def _attach(self, pose: Floats, number: int) -> None:
        del number
        self._welded = pose

    def _detach(self, number: int) -> None:
        del number

    def _follow_palm(self, number: int) -> tuple[Floats, Floats]:
        """Force and torque that let an object move with the palm, one step behind it."""
        model, body = self.models[number], self.scene.objects[number]
        palm, place = self._pose(self._palm).matrix, self._pose(body).matrix
        target = palm @ self._welded
        shift = target[:3, 3] - place[:3, 3]
        turn = Rotation.from_matrix(target[:3, :3] @ place[:3, :3].T).as_rotvec()
        speed, turning = self._velocity(self._palm)
        lever = place[:3, 3] - palm[:3, 3]
        wanted = speed + np.cross(turning, lever) + shift / (2 * STEP), turning + turn / (2 * STEP)
        missing = np.array(wanted) - self._velocity(body)
        inertia = place[:3, :3] * model.inertia @ place[:3, :3].T
        scale = self.mass_factor / STEP
        return scale * model.mass * missing[0], scale * inertia @ missing[1]

    def _pull(self, number: int) -> Floats:
        del number
        mean: Floats = np.mean(self._pulls, axis=0)
        return mean

    def _pin(self, pose: Pose, number: int) -> None:
        # heavy and without weight; the engine crashes if joints are locked
        self.place(pose, number=number)
        self._pinned.add(number)
        self._set_mass(number, PIN_FACTOR)

    def _unpin(self, number: int) -> None:
        if number in self._pinned:
            self._pinned.remove(number)
            self._set_mass(number, 1.0)

    def _set_mass(self, number: int, factor: float) -> None:
        """Give an object a multiple of its mass."""
        inertia = object_inertia(self.models[number], factor * self.mass_factor)
        self.scene.objects[number].SetSpatialInertiaInBodyFrame(self.context, inertia)


def _wrench(body: RigidBody, torque: Floats, force: Floats) -> ExternallyAppliedSpatialForce:
    made = ExternallyAppliedSpatialForce()
    made.body_index, made.p_BoBq_B = body.index(), np.zeros(3)
    made.F_Bq_W = SpatialForce(torque, force)
    return made


def _transform(pose: Pose) -> RigidTransform:
    turn = np.roll(pose.quaternion, 1)
    return RigidTransform(Quaternion(turn / np.linalg.norm(turn)), pose.position)
