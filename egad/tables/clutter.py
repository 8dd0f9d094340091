"""Schema of rounds of clearing a table."""

from egad.tables.columns import Result, integer, real, schema, text
from egad.tables.evaluation import ENGINE, ERRORS, FAILURE, PLATFORM, SUCCESS
from egad.tables.outcomes import (
    EXECUTION,
    POSE_FAILURES,
    SIMULATION_FAILURES,
    SUCTION_FAILURES,
    Outcome,
    listed,
)

GRASP_POSE = tuple(f"pose_{row}{part}" for row in "xyz" for part in ("x", "y", "z", "t"))
ROUND = ["scene", "noise", "round"]  # columns that tell rounds apart
CARRIED_OUT = (*(each for each in EXECUTION if each != Outcome.DROPPED), *SUCTION_FAILURES)

CLUTTER = schema(
    text("scene", "how the objects lie: single, packed or pile"),
    text("noise", "noise in what the cameras see: none, stereo, gamma, dex or points"),
    integer("round", "number of the round"),
    integer("attempt", "number of the attempt in its round"),
    text("seed", "seed of the round (hexadecimal)"),
    text("objects", "ids of the objects of the round, separated by spaces"),
    text(
        "factors",
        "sizes of the objects of the round / those that the scale rule gives, separated by spaces",
    ),
    integer("n_objects", "objects on the table at the beginning of the round"),
    integer("n_present", "objects on the table before the attempt"),
    text("present", "ids of the objects on the table before the attempt, separated by spaces"),
    SUCCESS,
    text("outcome", listed((*CARRIED_OUT, *SIMULATION_FAILURES, *POSE_FAILURES))),
    text("id", "id of the object that was held, or else of the one nearest to the grasp"),
    *(
        real(
            name,
            "pose of the hand that was tried, world frame: entry of a (3, 4) matrix, named by "
            "row and column; column t is the position between the pads in metres",
        )
        for name in GRASP_POSE
    ),
    real("width", "opening that the detector asked for", "m"),
    real("score", "score that the detector predicted"),
    real("stopped", "distance before the grasp at which something stopped the hand", "m"),
    ENGINE,
    PLATFORM,
    text("protocol", "rules of the round: egad, vgn, giga, edgegrasp, or custom for others"),
    ERRORS,
    FAILURE,
)

FILES = [
    Result(
        "D/clutter/G/P.parquet",
        "attempts of detector P to clear tables (`targets.clutter`), one per row",
        CLUTTER,
    )
]
