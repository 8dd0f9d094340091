"""Outcomes of grasp attempts, in simulation and on a real robot: a new one is added here alone."""

from collections.abc import Iterable
from enum import StrEnum
from typing import Self


class Outcome(StrEnum):
    """The outcome of an attempt; its value is what the column `outcome` of tables holds."""

    meaning: str
    color: str  # in charts, `#rrggbb`; empty for outcomes that no chart of attempts shows
    dark: bool  # whether text on this color is white

    def __new__(cls, value: str, meaning: str = "", color: str = "", dark: bool = False) -> Self:
        """A member with its attributes."""
        member = str.__new__(cls, value)
        member._value_ = value
        member.meaning, member.color, member.dark = meaning, color, dark
        return member

    SUCCESS = "success", "held to the end", "#0072b2", True
    COLLIDED = (
        "collided",
        "the hand was stopped on its way, or could not get there",
        "#d55e00",
        True,
    )
    MISSED = "missed", "the fingers closed, but never both pressed on the object at once", "#e69f00"
    NO_SEAL = "no_seal", "the suction cup did not seal", "#f0b94d"
    SLIPPED_CLOSING = "slipped_closing", "lost between the fingers before the lift", "#9bd5f5"
    SLIPPED_SHAKING = "slipped_shaking", "lost while it was shaken"
    SLIPPED_LIFTING = "slipped_lifting", "lost during the lift", "#56b4e9"
    DROPPED = "dropped", "lost while held up", "#009e73", True
    FAILED = "failed", "the simulation became unstable, or the object never came to rest", "#a7adb8"
    CRASHED = "crashed", "the physics engine crashed or hung, twice", "#5c6470", True
    NO_GRASP = "no_grasp", "the detector proposed no grasp", "#cc79a7"
    NOT_FINITE = "not_finite", "a number of the proposed grasp is NaN or infinite", "#b0568a"
    NOT_RIGID = "not_rigid", "the proposed pose is not a rotation and translation"
    TOO_WIDE = "too_wide", "the hand cannot open as wide as the proposed grasp is", "#943f72", True
    BELOW_TABLE = "below_table", "the fingertips would be under the table", "#77295a", True
    ERROR = (
        "error",
        "the detector crashed or returned something other than a grasp",
        "#591443",
        True,
    )
    TIMEOUT = "timeout", "the detector took too long", "#3c002d", True
    # only noted by people who watch a robot
    SLIPPED = "slipped", "lost, but you did not see when", "#2f8fc4", True
    OTHER = "other", "any other failure: say which in a note", "#7d8591"


def _group(*names: str) -> tuple[Outcome, ...]:
    return tuple(map(Outcome, names))


EXECUTION = _group("success", "collided", "missed", "slipped_closing", "slipped_lifting", "dropped")
"""A grasp was carried out."""

SUCTION_FAILURES = (Outcome.NO_SEAL,)
"""Only for a suction cup."""

JAW_FAILURES = (Outcome.MISSED, Outcome.SLIPPED_CLOSING)
"""Only for jaws."""

SHAKEN = (*EXECUTION[:4], Outcome.SLIPPED_SHAKING, *EXECUTION[4:])
"""A labelled grasp was closed in free space, shaken and lifted."""

SIMULATION_FAILURES = (Outcome.FAILED, Outcome.CRASHED)
"""The physics engine could not tell."""

DETECTOR_FAILURES = _group("no_grasp", "not_finite", "too_wide", "below_table", "error", "timeout")
"""The detector gave nothing that can be tried."""

POSE_FAILURES = (Outcome.NOT_RIGID, *DETECTOR_FAILURES)
"""The same for a detector that answers with poses."""

NOTED_BY_HAND = (Outcome.SLIPPED, Outcome.OTHER)
"""Only in tables of a real robot."""

OBSERVABLE = (
    *EXECUTION,
    *SUCTION_FAILURES,
    *NOTED_BY_HAND,
    *_group("no_grasp", "error", "timeout"),
)
"""The outcomes that a person beside a robot can tell apart."""

CHARTED = (
    *_group("success", "slipped_closing", "slipped_lifting", "slipped", "dropped", "missed"),
    *_group("no_seal", "collided"),
    *DETECTOR_FAILURES,
    *SIMULATION_FAILURES,
    Outcome.OTHER,
)
"""The outcomes of trials in the order of bars of charts."""


def observable(*, cup: bool) -> tuple[Outcome, ...]:
    """Those of `OBSERVABLE` that jaws, or a suction cup, can have."""
    others = JAW_FAILURES if cup else SUCTION_FAILURES
    return tuple(each for each in OBSERVABLE if each not in others)


def listed(outcomes: Iterable[Outcome]) -> str:
    """Outcomes as a phrase: `failed, crashed or error`."""
    *names, last = outcomes
    return f"{', '.join(names)} or {last}" if names else str(last)
