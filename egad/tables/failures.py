"""Tables of the failures of a detector."""

from egad.tables.columns import (
    CELLS,
    COMPLEXITY,
    FLOAT,
    GRASPABILITY,
    ID,
    STRING,
    Result,
    binary,
    boolean,
    integer,
    pose,
    real,
    schema,
    text,
    values,
)
from egad.tables.evolution import ARCHIVE, GENOME

_COUNTS = [
    integer("n_pairs", "number of fresh drops at which detector and reference were both tried"),
    *(
        integer(name, f"number of fresh drops at which {who} held the object to the end")
        for name, who in (
            ("reference_successes", "the reference"),
            ("detector_successes", "the detector"),
            ("only_reference", "only the reference"),
            ("only_detector", "only the detector"),
        )
    ),
    real("difference", "(only_reference - only_detector) / n_pairs"),
]
RESULTS = schema(
    real("objective", "estimated difference, shrunk towards 0, in steps of 0.1"),
    *(
        field.with_name(f"{field.name}_{engine}")
        for engine in ("mujoco", "pybullet")
        for field in _COUNTS
    ),
)
EXPLAINED = schema(
    integer(
        "n_explained",
        "number of explained drops: failed drops at which other proposals were also tried",
    ),
    integer("n_nothing", "number of explained drops at which nothing was proposed"),
    integer(
        "n_not_chosen",
        "number of explained drops at which another one of the first ten proposals holds the "
        "object",
    ),
    integer(
        "n_none_good",
        "number of explained drops at which none of the first ten proposals holds the object",
    ),
)
VERDICT = text(
    "verdict",
    "failure; or why the object is not one: cell_full, not_measured, not_simulated, "
    "detector_succeeds, not_graspable (the reference fails, too), not_printable, not_confirmed",
)
EXAMINED = schema(
    ID,
    integer("shard", "number of the independent search"),
    integer("step", "step of the search"),
    text("source", "archive, child (of failures or of the archive) or random"),
    values("parents", "ids of the parents", of=STRING),
    VERDICT,
    text("reason", "reason for the verdict; empty if the counts explain it"),
    COMPLEXITY,
    GRASPABILITY,
    *CELLS,
    integer("attempts", "number of simulated grasps of the detector and of the reference"),
    *RESULTS,
    *GENOME,
    binary("voxels", "solid voxels, as in `archive.parquet`; empty if no attempt was made"),
    binary("graph", "packed Reeb graph; empty if the objective is 0"),
)

FAILURES = schema(*ARCHIVE, *RESULTS, *EXPLAINED)

FAILURE_ATTEMPTS = schema(
    ID,
    text("engine", "physics engine"),
    text("purpose", "screen, choose, confirm or explain"),
    integer("drop", "number of the drop, which decides where the object lies"),
    text("who", "who proposed the grasp: detector or reference"),
    integer(
        "rank", "rank of the proposal: 0 for the one chosen, n for the one after n better ones"
    ),
    boolean("success", "whether the object was still held at the end"),
    text("outcome", "outcome of the attempt"),
    *pose("rest", "pose of the object before the attempt"),
    values(
        "pose", "first three rows of the pose of the hand; empty if there was no grasp", of=FLOAT
    ),
    real("width", "opening of the hand", "m"),
    real("score", "score that was predicted for the grasp"),
    text("failure", "what the detector did wrong; empty if nothing"),
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
