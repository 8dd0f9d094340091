"""Outcomes of grasp attempts, in simulation and on a real robot."""

from collections.abc import Iterable
from enum import StrEnum


class Outcome(StrEnum):
    """The outcome of an attempt; its value is what the column `outcome` of tables holds.

    Attributes:
        SUCCESS: Held up to the end.
        COLLIDED: The hand was stopped on its way, or the grasp is out of the arm's reach.
        MISSED: The fingers closed, but never both pressed on the object at the same time.
        NO_SEAL: The suction cup did not seal.
        SLIPPED_CLOSING: Lost between the fingers before it was lifted.
        SLIPPED_SHAKING: Lost while it was shaken.
        SLIPPED_LIFTING: Lost while it was lifted.
        DROPPED: Lost while it was held up.
        FAILED: The simulation became unstable, or the object never came to rest.
        CRASHED: The physics engine crashed or hung, twice.
        NO_GRASP: The detector proposed no grasp.
        NOT_FINITE: A number of the proposed grasp is NaN or infinite.
        NOT_RIGID: The proposed pose is not a rotation and translation.
        TOO_WIDE: The hand cannot open as wide as the proposed grasp is.
        BELOW_TABLE: The fingertips would be under the table.
        ERROR: The detector raised an error or returned something other than grasps.
        TIMEOUT: The detector took too long.
        SLIPPED: Lost at any time; noted by people who watch a robot.
        OTHER: Any other failure; noted by people who watch a robot.
    """

    SUCCESS = "success"
    COLLIDED = "collided"
    MISSED = "missed"
    NO_SEAL = "no_seal"
    SLIPPED_CLOSING = "slipped_closing"
    SLIPPED_SHAKING = "slipped_shaking"
    SLIPPED_LIFTING = "slipped_lifting"
    DROPPED = "dropped"
    FAILED = "failed"
    CRASHED = "crashed"
    NO_GRASP = "no_grasp"
    NOT_FINITE = "not_finite"
    NOT_RIGID = "not_rigid"
    TOO_WIDE = "too_wide"
    BELOW_TABLE = "below_table"
    ERROR = "error"
    TIMEOUT = "timeout"
    SLIPPED = "slipped"
    OTHER = "other"


EXECUTION = (
    Outcome.SUCCESS,
    Outcome.COLLIDED,
    Outcome.MISSED,
    Outcome.SLIPPED_CLOSING,
    Outcome.SLIPPED_LIFTING,
    Outcome.DROPPED,
)
"""A grasp was carried out."""

SUCTION_FAILURES = (Outcome.NO_SEAL,)
"""Only for a suction cup."""

JAW_FAILURES = (Outcome.MISSED, Outcome.SLIPPED_CLOSING)
"""Only for jaws."""

SHAKEN = (*EXECUTION[:4], Outcome.SLIPPED_SHAKING, *EXECUTION[4:])
"""A labelled grasp was closed in free space, shaken and lifted."""

SIMULATION_FAILURES = (Outcome.FAILED, Outcome.CRASHED)
"""The physics engine could not tell."""

DETECTOR_FAILURES = (
    Outcome.NO_GRASP,
    Outcome.NOT_FINITE,
    Outcome.TOO_WIDE,
    Outcome.BELOW_TABLE,
    Outcome.ERROR,
    Outcome.TIMEOUT,
)
"""The detector gave nothing that can be tried."""

POSE_FAILURES = (Outcome.NOT_RIGID, *DETECTOR_FAILURES)
"""The same for a detector that answers with poses."""

NOTED_BY_HAND = (Outcome.SLIPPED, Outcome.OTHER)
"""Only in tables of a real robot."""

OBSERVABLE = (
    *EXECUTION,
    *SUCTION_FAILURES,
    *NOTED_BY_HAND,
    Outcome.NO_GRASP,
    Outcome.ERROR,
    Outcome.TIMEOUT,
)
"""The outcomes that a person beside a robot can tell apart."""


def observable(*, cup: bool) -> tuple[Outcome, ...]:
    """Those of `OBSERVABLE` that jaws, or a suction cup, can have."""
    others = JAW_FAILURES if cup else SUCTION_FAILURES
    return tuple(each for each in OBSERVABLE if each not in others)


def listed(outcomes: Iterable[Outcome]) -> str:
    """Outcomes as a phrase: `failed, crashed or error`."""
    *names, last = outcomes
    return f"{', '.join(names)} or {last}" if names else str(last)
