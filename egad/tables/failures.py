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
    column("n_pairs", INT, "fresh drops from which both were tried"),
    column("reference_successes", INT, "of these, the reference held the object to the end"),
    column("detector_successes", INT, "of these, the detector did"),
    column("only_reference", INT, "of these, the reference alone did"),
    column("only_detector", INT, "of these, the detector alone did"),
    column("regret", FLOAT, "(only_reference - only_detector) / n_pairs"),
]


def counts_in(engine: str) -> list[pa.Field]:
    """The columns of what came of the fresh drops in an engine: NAME_ENGINE."""
    return [field.with_name(f"{field.name}_{engine}") for field in _COUNTS]


RESULTS = pa.schema(
    [
        column("objective", FLOAT, "estimated regret, shrunk, in steps of 0.1"),
        *counts_in("mujoco"),
        *counts_in("pybullet"),
    ]
)
EXPLAINED = pa.schema(
    [
        column("n_explained", INT, "failed drops at which other proposals were tried, too"),
        column("n_nothing", INT, "of these, nothing was proposed"),
        column("n_not_chosen", INT, "of these, another one of the first ten proposals holds"),
        column("n_none_good", INT, "of these, none of the first ten proposals does"),
    ]
)
VERDICT = column(
    "verdict",
    STRING,
    "failure; or why it is none: cell_full, not_measured, not_simulated, detector_succeeds, "
    "not_graspable (the reference fails, too), not_printable, not_confirmed",
)
EXAMINED = pa.schema(
    [
        ID,
        column("shard", INT, "number of the search"),
        column("step", INT, "step of the search"),
        column("source", STRING, "archive, child (of failures or of the archive) or random"),
        column("parents", pa.list_(STRING), "ids of the parents"),
        VERDICT,
        column("reason", STRING, "why in words; empty if the counts say it"),
        COMPLEXITY,
        GRASPABILITY,
        *CELLS,
        column("attempts", INT, "simulated grasps, of the detector and of the reference"),
        *RESULTS,
        *GENOME,
        column("voxels", BINARY, "as in `archive.parquet`; empty if no attempt was made"),
        column("graph", BINARY, "packed Reeb graph; empty if the objective is 0"),
    ]
)

FAILURES = pa.schema([*ARCHIVE, *RESULTS, *EXPLAINED])

MATCHED = pa.schema(
    [
        column("label", STRING, "name in the set: A and the number of the pair, or B"),
        column("pair", INT, "number of the pair, from the simplest failure on"),
        column("is_failure", BOOL, "whether it is the failure of the pair, or its partner"),
        column("similarity", FLOAT, "of the shapes of the two, 0 to 1"),
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
        column("who", STRING, "detector or reference"),
        column("rank", INT, "0 for what was chosen, n for the proposal after n better ones"),
        column("success", BOOL, "whether the object was still held at the end"),
        column("outcome", STRING, "what came of it"),
        *pose("rest", "where the object lay"),
        column("pose", pa.list_(FLOAT), "first three rows of the pose of the hand; empty: none"),
        column("width", FLOAT, "how far the hand opens", "m"),
        column("score", FLOAT, "what is expected of the grasp"),
        column("failure", STRING, "what the detector did wrong; empty if nothing"),
    ]
)

FILES = [
    Result(
        "D/failures/G/P.parquet",
        "failures of detector P with gripper G: objects that can be grasped, and that it does not "
        "grasp (`targets.failures`)",
        FAILURES,
    ),
    Result("D/failures/G/P.examined.parquet", "all objects that the search looked at", EXAMINED),
    Result("D/failures/G/P.attempts.parquet", "their attempts", FAILURE_ATTEMPTS),
    Result("D/failures/G/P.html", "the same as a page, with films of the worst failures"),
]
