"""Servos that drive the joints of a robot, as all engines that solve them implicitly have them."""

from typing import NamedTuple

from egad.sim.robot import Robot
from egad.sim.world import CLOSING_SPEED, TIME_STEP

SUBSTEPS = 2  # steps of the engine in a time step
# Servos are stiff, but have the lag that any controller has.
SLACK = 0.01  # metres or radians off the target, where an arm uses all its strength
DAMPING_TIME = 0.02  # seconds
FINGER_SLACK = 0.002  # metres
ARMATURE = 0.004  # s2/m or s2: inertia of what drives a joint, by its strength


class Servo(NamedTuple):
    """A motor that pulls a joint to a position, within its strength."""

    joint: str  # its name
    strength: float  # N or N m
    stiffness: float  # N/m or N m
    damping: float  # N s/m or N m s
    armature: float  # inertia of the drive, kg or kg m2


def arm_servos(robot: Robot) -> list[Servo]:
    """Servos of the joints that move the palm."""
    return [
        Servo(name, force, force / SLACK, DAMPING_TIME * force / SLACK, ARMATURE * force)
        for name, force in robot.strength.items()
    ]


def finger_servos(robot: Robot) -> list[Servo]:
    """Servos of the joints that close the hand.

    Without stiffness, their damping makes them motors: the force of a closing finger falls with its
    speed, to zero at full speed.
    """
    drive = robot.drive
    force, factor = drive.strength, abs(drive.closing)
    stiffness, damping = force / (FINGER_SLACK * factor), force / (CLOSING_SPEED * factor)
    armature = 2 * TIME_STEP / SUBSTEPS * force / (CLOSING_SPEED * factor)
    return [Servo(name, force, stiffness, damping, armature) for name in drive.joints]
