"""Attempts of several hands at the same objects, and what became of them."""

from enum import StrEnum
from typing import Self

from egad.tables.columns import FLOAT, ID, Result, integer, pose, real, schema, text, values
from egad.tables.evaluation import ENGINE, ERRORS, FAILURE, PLACE, PLATFORM, SUCCESS
from egad.tables.outcomes import DETECTOR_FAILURES, Outcome

SWING = 30.0  # degrees


class Cause(StrEnum):
    """What became of an attempt, or why it failed; its value is what tables hold."""

    meaning: str
    color: str  # in charts

    def __new__(cls, value: str, meaning: str = "", color: str = "") -> Self:
        """A member with its attributes."""
        member = str.__new__(cls, value)
        member._value_ = value
        member.meaning, member.color = meaning, color
        return member

    HELD = "held", "held to the end", "#0072b2"
    SWUNG = (
        "swung",
        f"held to the end, but turned by more than {SWING:g} degrees from how it lay",
        "#7fb8d8",
    )
    DROPPED = "dropped", "lost while held up", "#009e73"
    SLIPPED = "slipped", "lost while the hand closed or lifted", "#56b4e9"
    MISSED = "missed", "the hand closed beside it, or its cup did not seal", "#e69f00"
    FINGER = "finger", "a finger or jaw met the object on its way", "#d55e00"
    PALM = "palm", "the palm, or the stem of a cup, met the object", "#943f72"
    TABLE = "table", "the hand met the table", "#8a6d3b"
    UNREACHABLE = "none_reachable", "no grasp was proposed that the hand can reach", "#cc79a7"
    DETECTOR = "detector", "the detector failed", "#591443"
    ENGINE = "engine", "the simulation became unstable", "#a7adb8"


OF_OUTCOME = {
    **dict.fromkeys(DETECTOR_FAILURES, Cause.DETECTOR),
    Outcome.NO_GRASP: Cause.UNREACHABLE,
    Outcome.TOO_WIDE: Cause.UNREACHABLE,
    Outcome.BELOW_TABLE: Cause.UNREACHABLE,
    Outcome.NOT_RIGID: Cause.DETECTOR,
    Outcome.MISSED: Cause.MISSED,
    Outcome.NO_SEAL: Cause.MISSED,
    Outcome.SLIPPED_CLOSING: Cause.SLIPPED,
    Outcome.SLIPPED_LIFTING: Cause.SLIPPED,
    Outcome.DROPPED: Cause.DROPPED,
    Outcome.FAILED: Cause.ENGINE,
    Outcome.CRASHED: Cause.ENGINE,
}
"""The causes of all outcomes but successes and collisions, which have several."""

GRASPERS = {
    "best": "best grasps",
    "detector": "detector",
    "naive": "naive grasps",
}
"""Who chose the grasps that hands are judged by: a search, a detector, or nobody."""

HAND_ATTEMPTS = schema(
    text("hand", "name of the hand"),
    PLACE,
    ID,
    real("smallest_side", "smallest side of the minimum-volume box of the object", "m"),
    real("longest_side", "longest side of that box", "m"),
    text(
        "grasper",
        "who chose the grasp: search (attempts from which the best grasps are learned, which do "
        "not count), best, detector or naive",
    ),
    integer("drop", "number of the drop, the same for all hands"),
    integer("attempt", "number of the grasp at this drop"),
    SUCCESS,
    text("outcome", "outcome of the attempt"),
    text("cause", f"what became of it, or why it failed: {', '.join(Cause)}"),
    real("turned", "rotation of the object from where it lay to the end, if held", "degrees"),
    *pose("rest", "pose of the object before the attempt"),
    values(
        "pose", "first three rows of the pose of the hand; empty if there was no grasp", of=FLOAT
    ),
    real("width", "opening of the hand", "m"),
    ENGINE,
    PLATFORM,
    ERRORS,
    FAILURE,
)

FILES = [
    Result("D/hands/card.html", "report card of the grippers of `targets`; works offline"),
    Result("D/hands/attempts.parquet", "attempts of these at the evaluation set", HAND_ATTEMPTS),
]
