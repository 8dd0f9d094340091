"""Simulated labels of grasps: closed in free space, shaken, and lifted.

ACRONYM (Eppner 2021, section III) closes the fingers on an object that floats without weight, moves
the hand up and down along its approach, rotates it back and forth about it, and checks whether both
fingers still hold the object. Here the object is then lifted under gravity, as in every trial.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from egad.grippers import Gripper, check_jaws
from egad.sim.arms import Arm, HandPose, TurningAxis
from egad.sim.engines import open_world
from egad.sim.execution import lift_and_hold
from egad.sim.jaws import Hand
from egad.sim.labelled_trials import floating_pose
from egad.sim.model import Model
from egad.sim.parameters import COLLISION_FORCE, Lifting, SimulatedLabelParameters
from egad.sim.world import DOWN, TIME_STEP, WEIGHTLESS, Pose, UnstableError, World
from egad.tables import parquet
from egad.tables.grasping import MOTIONS
from egad.tables.outcomes import SIMULATION_FAILURES, Outcome

# The hand moves by at most 26 mm and accelerates at 11 m/s2, a little more than gravity. It turns
# by at most 25 degrees, with the same acceleration 6 cm off its axis. ACRONYM gives no numbers.
SHAKES = 2  # each way
FREQUENCY = 3.0  # Hz
AMPLITUDE = 0.03  # metres, before the envelope
SWING = 0.5  # radians, before the envelope
NOT_A_MOTION = (np.nan, np.nan)


class SimulatedGrasp(NamedTuple):
    """The result of a grasp."""

    # `success`: held to the end; `collided`, `missed`, `slipped_closing`, `slipped_shaking`,
    # `slipped_lifting` or `dropped`, whichever came first; `failed`
    outcome: Outcome
    # how far the object moved relative to the hand while the fingers closed: its center of mass in
    # metres, and its rotation in radians
    closing: tuple[float, float] = NOT_A_MOTION
    shaking: tuple[float, float] = NOT_A_MOTION  # the same while it was shaken; NaN if it was not

    @property
    def success(self) -> bool | None:
        """Whether it held to the end; None if the engine could not tell."""
        return None if self.outcome in SIMULATION_FAILURES else self.outcome == Outcome.SUCCESS


def simulate_labels(
    model: Model, grasps: pd.DataFrame, settings: SimulatedLabelParameters
) -> pd.DataFrame:
    """Simulate collision-free `GRASPS` of an object, each by itself: `SIMULATED_GRASPS`."""
    chosen = chosen_grasps(grasps, settings)
    found = simulate_grasps(model, grasps.iloc[chosen], settings)
    return with_simulated_labels(grasps, chosen, found, settings)


def simulate_grasps(
    model: Model, grasps: pd.DataFrame, settings: SimulatedLabelParameters
) -> list[SimulatedGrasp]:
    """Simulate grasps: columns center, axis and approach (x, y and z each) and width, metres."""
    check_jaws(settings.gripper, "a simulated label")
    gripper = settings.gripper.model_copy(update={"friction": settings.quality.friction})
    arm = TurningAxis(gripper)
    with open_world(settings.simulated_label.engine, [model], arm.robot) as world:
        return [
            simulate_grasp(
                world, arm, *_floating(model, row, gripper), float(row["width"]), settings.trials
            )
            for row in parquet.records(grasps)
        ]


def chosen_grasps(grasps: pd.DataFrame, settings: SimulatedLabelParameters) -> NDArray[np.int64]:
    """Row numbers of the grasps to simulate: the first ones that are free of collisions."""
    return np.flatnonzero(grasps["collision_free"])[: settings.simulated_label.grasps]


def with_simulated_labels(
    grasps: pd.DataFrame,
    chosen: NDArray[np.int64],
    found: Sequence[SimulatedGrasp],
    settings: SimulatedLabelParameters,
) -> pd.DataFrame:
    """Grasps with the columns of `SIMULATED_GRASPS`, from the results of the chosen rows."""
    rows = [(each.outcome.value, each.success, *each.closing, *each.shaking) for each in found]
    names = ["simulated_outcome", "simulated_success", *MOTIONS]
    labels = pd.DataFrame(rows, index=chosen, columns=names, dtype=object)
    labels["simulated_engine"] = settings.simulated_label.engine
    return grasps.reset_index(drop=True).join(labels)


def simulate_grasp(
    world: World, arm: Arm, start: Pose, hand_pose: HandPose, contact: float, lifting: Lifting
) -> SimulatedGrasp:
    """Close the open hand on an object that floats at `start`, shake it and lift it."""
    world.reset()
    world.place(start)
    world.set_gravity(WEIGHTLESS)
    hand = Hand(world, arm, hand_pose, arm.robot.gripper.opening, contact)
    try:
        return _simulated(hand, hand_pose, lifting)
    except UnstableError:
        return SimulatedGrasp(Outcome.FAILED)


def _simulated(hand: Hand, hand_pose: HandPose, lifting: Lifting) -> SimulatedGrasp:
    world, before = hand.world, hand.world.pose()
    world.step()
    if world.forces().hand > COLLISION_FORCE:
        return SimulatedGrasp(Outcome.COLLIDED)
    touched = hand.close()
    held = world.pose()
    closing = _motion(before, held)
    if not hand.pinches():
        return SimulatedGrasp(Outcome.SLIPPED_CLOSING if touched else Outcome.MISSED, closing)
    for place in _shaking(hand_pose):
        hand.steer(place)
        world.step()
    shaking = _motion(held, world.pose())  # the hand is back where it was
    if not hand.pinches():
        return SimulatedGrasp(Outcome.SLIPPED_SHAKING, closing, shaking)
    world.set_gravity(DOWN)
    return SimulatedGrasp(lift_and_hold(hand, lifting)[0], closing, shaking)


def _shaking(hand_pose: HandPose) -> Iterator[HandPose]:
    """Poses of the hand, one per time step: up and down, then back and forth, from rest to rest."""
    time = TIME_STEP * np.arange(1, round(SHAKES / FREQUENCY / TIME_STEP) + 1)
    # The envelope lets the hand begin and end at rest.
    wave = np.sin(2 * np.pi * FREQUENCY * time) * np.sin(np.pi * FREQUENCY / SHAKES * time) ** 2
    for shift in AMPLITUDE * wave:
        yield hand_pose._replace(height=hand_pose.height + float(shift))
    for turn in SWING * wave:
        yield hand_pose._replace(angle=hand_pose.angle + float(turn))


def _motion(before: Pose, after: Pose) -> tuple[float, float]:
    turn = Rotation.from_quat(after.quaternion) * Rotation.from_quat(before.quaternion).inv()
    shift = np.linalg.norm(after.position - before.position)
    return float(shift), float(turn.magnitude())


def _floating(model: Model, row: dict[str, object], gripper: Gripper) -> tuple[Pose, HandPose]:
    pose, grasp = floating_pose(model, row, gripper)
    return pose, HandPose(*grasp.center[:2], grasp.tip, grasp.angle)
