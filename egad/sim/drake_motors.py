"""The motors of a robot in Drake: where they pull, and how the joints of a linkage follow."""

from collections.abc import Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context

from egad._util.arrays import Floats
from egad.sim.drake_model import LINKAGE_DAMPING_TIME, STEP, linkage_stiffness
from egad.sim.drives import RIGHT
from egad.sim.robot import Robot
from egad.sim.world import CLOSING_SPEED


class Motors:
    """The motors of the arm, then of the fingers, then of the joints that follow these.

    Attributes:
        targets: Where they pull, metres or radians.
        speeds: The speeds that go with it.
        closing: Whether the fingers close, instead.
    """

    def __init__(self, plant: MultibodyPlant, robot: Robot) -> None:
        """Take the motors of a robot, in the order in which they were added to its plant."""
        self._plant, self._robot = plant, robot
        first, names = len(robot.arm), [*robot.arm, *robot.drive.joints]
        self.arm, self.fingers = slice(0, first), slice(first, len(names))
        names += [each.joint for each in robot.followers]
        self._joints = [plant.GetJointByName(name) for name in names]
        self._positions = [joint.position_start() for joint in self._joints]
        self._speeds = [joint.velocity_start() for joint in self._joints]
        self.targets, self.speeds, self.closing = np.zeros(len(names)), np.zeros(len(names)), False

    def place(self, context: Context, joints: Sequence[float], opening: float) -> None:
        """Put the robot at rest at positions of the arm and an opening, metres."""
        fingers = [self._robot.drive.position(opening)] * len(self._robot.drive.joints)
        followers = [each.at(opening / 2) for each in self._robot.followers]
        self.targets, self.speeds = np.array([*joints, *fingers, *followers]), 0 * self.targets
        self.closing = False
        positions, speeds = self._plant.GetPositions(context), self._plant.GetVelocities(context)
        positions[self._positions], speeds[self._speeds] = self.targets, 0.0
        self._plant.SetPositions(context, positions)
        self._plant.SetVelocities(context, speeds)

    def state(self, context: Context, of: slice = slice(None)) -> tuple[Floats, Floats]:
        """Positions and speeds of some motors."""
        positions = self._plant.GetPositions(context)[self._positions[of]]
        return positions, self._plant.GetVelocities(context)[self._speeds[of]]

    def apply(self, context: Context) -> None:
        """Give all motors their commands for the next step of the engine."""
        positions, speeds = self.state(context)
        if self.closing:
            self.speeds[self.fingers] = self._robot.drive.closing * CLOSING_SPEED
            ahead = STEP * self.speeds[self.fingers]
            self.targets[self.fingers] = positions[self.fingers] + ahead
        if self._robot.followers:
            self._follow(context, positions, speeds)
        model = self._joints[0].model_instance()
        port = self._plant.get_desired_state_input_port(model)
        port.FixValue(context, np.concatenate([self.targets, self.speeds]))

    def _follow(self, context: Context, positions: Floats, speeds: Floats) -> None:
        """Pull the joints of a linkage along, and their fingers back with what they bear."""
        back = np.zeros(self._plant.num_velocities())
        for number, follower in enumerate(self._robot.followers, self.fingers.stop):
            finger = self.fingers.start + (follower.side == RIGHT)
            slope = follower.slope(float(positions[finger]))
            self.targets[number] = follower.at(float(positions[finger]))
            self.speeds[number] = slope * speeds[finger]
            missing = self.targets[number] - positions[number]
            late = self.speeds[number] - speeds[number]
            pull = linkage_stiffness(self._robot, follower) * (
                missing + LINKAGE_DAMPING_TIME * late
            )
            back[self._speeds[finger]] -= slope * pull
        self._plant.get_applied_generalized_force_input_port().FixValue(context, back)
