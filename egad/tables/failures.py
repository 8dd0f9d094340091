"""Tables of the failures of a detector."""

import pyarrow as pa

from egad.tables.columns import (
    BINARY,
    BOOL,
    CELLS,
    COMPLEXITY,
    FLOAT,
    GRASPABILITY,
    ID,
    INT,
    STRING,
    Result,
    column,
    pose,
)
from egad.tables.evolution import ARCHIVE, GENOME

_COUNTS = [
    column("n_pairs", INT, "number of fresh drops at which detector and reference were both tried"),
    *(
        column(name, INT, f"number of fresh drops at which {who} held the object to the end")
        for name, who in (
            ("reference_successes", "the reference"),
            ("detector_successes", "the detector"),
            ("only_reference", "only the reference"),
            ("only_detector", "only the detector"),
        )
    ),
    column("difference", FLOAT, "(only_reference - only_detector) / n_pairs"),
]


def counts_in(engine: str) -> list[pa.Field]:
    """The columns for the results of the fresh drops in an engine: NAME_ENGINE."""
    return [field.with_name(f"{field.name}_{engine}") for field in _COUNTS]


RESULTS = pa.schema(
    [
        column("objective", FLOAT, "estimated difference, shrunk towards 0, in steps of 0.1"),
        *counts_in("mujoco"),
        *counts_in("pybullet"),
    ]
)
EXPLAINED = pa.schema(
    [
        column(
            "n_explained",
            INT,
            "number of explained drops: failed drops at which other proposals were also tried",
        ),
        column("n_nothing", INT, "number of explained drops at which nothing was proposed"),
        column(
            "n_not_chosen",
            INT,
            "number of explained drops at which another one of the first ten proposals holds the "
            "object",
        ),
        column(
            "n_none_good",
            INT,
            "number of explained drops at which none of the first ten proposals holds the object",
        ),
    ]
)
VERDICT = column(
    "verdict",
    STRING,
    "failure; or why the object is not one: cell_full, not_measured, not_simulated, "
    "detector_succeeds, not_graspable (the reference fails, too), not_printable, not_confirmed",
)
EXAMINED = pa.schema(
    [
        ID,
        column("shard", INT, "number of the independent search"),
        column("step", INT, "step of the search"),
        column("source", STRING, "archive, child (of failures or of the archive) or random"),
        column("parents", pa.list_(STRING), "ids of the parents"),
        VERDICT,
        column("reason", STRING, "reason for the verdict; empty if the counts explain it"),
        COMPLEXITY,
        GRASPABILITY,
        *CELLS,
        column("attempts", INT, "number of simulated grasps of the detector and of the reference"),
        *RESULTS,
        *GENOME,
        column(
            "voxels", BINARY, "solid voxels, as in `archive.parquet`; empty if no attempt was made"
        ),
        column("graph", BINARY, "packed Reeb graph; empty if the objective is 0"),
    ]
)

FAILURES = pa.schema([*ARCHIVE, *RESULTS, *EXPLAINED])

MATCHED = pa.schema(
    [
        column("label", STRING, "name in the set: A and the number of the pair, or B"),
        column("pair", INT, "number of the pair, starting with the simplest failure"),
        column(
            "is_failure", BOOL, "whether the object is the failure of the pair, not its partner"
        ),
        column("similarity", FLOAT, "similarity of the two shapes, 0 to 1"),
        *ARCHIVE,
        *counts_in("mujoco"),
        *counts_in("pybullet"),
    ]
)

FAILURE_ATTEMPTS = pa.schema(
    [
        ID,
        column("engine", STRING, "physics engine"),
        column(
            "purpose",
            STRING,
            "screen, choose, confirm or explain; of a matched set: choose, qualify or matched",
        ),
        column("drop", INT, "number of the drop, which decides where the object lies"),
        column("who", STRING, "who proposed the grasp: detector or reference"),
        column(
            "rank",
            INT,
            "rank of the proposal: 0 for the one chosen, n for the one after n better ones",
        ),
        column("success", BOOL, "whether the object was still held at the end"),
        column("outcome", STRING, "outcome of the attempt"),
        *pose("rest", "pose of the object before the attempt"),
        column(
            "pose",
            pa.list_(FLOAT),
            "first three rows of the pose of the hand; empty if there was no grasp",
        ),
        column("width", FLOAT, "opening of the hand", "m"),
        column("score", FLOAT, "score that was predicted for the grasp"),
        column("failure", STRING, "what the detector did wrong; empty if nothing"),
    ]
)

FILES = [
    Result(
        "D/failures/G/P.parquet",
        "failures of detector P with gripper G: objects that can be grasped, but that it does not "
        "grasp (`targets.failures`)",
        FAILURES,
    ),
    Result(
        "D/failures/G/P.examined.parquet",
        "all objects that the search for failures of detector P considered",
        EXAMINED,
    ),
    Result(
        "D/failures/G/P.attempts.parquet",
        "attempts at the objects that the search for failures of detector P considered, one per "
        "row",
        FAILURE_ATTEMPTS,
    ),
    Result("D/failures/G/P.html", "failures of detector P as a page, with films of the worst ones"),
]
