"""Schema of rounds of clearing a table."""

import pyarrow as pa

from egad.tables.columns import FLOAT, INT, STRING, Result, column
from egad.tables.evaluation import ENGINE, ERRORS, FAILURE, SUCCESS
from egad.tables.outcomes import (
    POSE_FAILURES,
    SIMULATION_FAILURES,
    SUCTION_FAILURES,
    Outcome,
    listed,
)

GRASP_POSE = tuple(f"pose_{row}{part}" for row in "xyz" for part in ("x", "y", "z", "t"))
ROUND = ["scene", "noise", "round"]  # columns that tell rounds apart
CARRIED_OUT = (
    Outcome.SUCCESS,
    Outcome.COLLIDED,
    Outcome.MISSED,
    Outcome.SLIPPED_CLOSING,
    Outcome.SLIPPED_LIFTING,
    *SUCTION_FAILURES,
)

CLUTTER = pa.schema(
    [
        column("scene", STRING, "how the objects lie: single, packed or pile"),
        column(
            "noise", STRING, "noise in what the cameras see: none, stereo, gamma, dex or points"
        ),
        column("round", INT, "number of the round"),
        column("attempt", INT, "number of the attempt in its round"),
        column("seed", STRING, "seed of the round (hexadecimal)"),
        column("objects", STRING, "ids of the objects of the round, separated by spaces"),
        column(
            "factors",
            STRING,
            "sizes of the objects of the round / those that the scale rule gives, separated by "
            "spaces",
        ),
        column("n_objects", INT, "objects on the table at the beginning of the round"),
        column("n_present", INT, "objects on the table before the attempt"),
        column(
            "present",
            STRING,
            "ids of the objects on the table before the attempt, separated by spaces",
        ),
        SUCCESS,
        column("outcome", STRING, listed((*CARRIED_OUT, *SIMULATION_FAILURES, *POSE_FAILURES))),
        column(
            "id", STRING, "id of the object that was held, or else of the one nearest to the grasp"
        ),
        *(
            column(
                name,
                FLOAT,
                "pose of the hand that was tried, world frame: entry of a (3, 4) matrix, named by "
                "row and column; column t is the position between the pads in metres",
            )
            for name in GRASP_POSE
        ),
        column("width", FLOAT, "opening that the detector asked for", "m"),
        column("score", FLOAT, "score that the detector predicted"),
        column(
            "stopped", FLOAT, "distance before the grasp at which something stopped the hand", "m"
        ),
        ENGINE,
        column(
            "protocol",
            STRING,
            "rules of the round: egad, vgn, giga, edgegrasp, or custom for others",
        ),
        ERRORS,
        FAILURE,
    ]
)

FILES = [
    Result(
        "D/clutter/G/P.parquet",
        "attempts of detector P to clear tables (`targets.clutter`), one per row",
        CLUTTER,
    ),
]
