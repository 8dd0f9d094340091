"""Tables of a dataset release: objects, grasps with simulated labels, the evaluation set."""

from egad.tables.columns import Result, boolean, integer, real, schema, text, vector
from egad.tables.evaluation import EVAL49
from egad.tables.grasping import ANTIPODAL_RATES, SIMULATED_GRASPS
from egad.tables.objects import OBJECTS

MAX_FILES = 10_000  # in a folder of a repository of Hugging Face

SPLIT = text("split", "train, validation or test; the same for all rows of an object")
MESH = text("mesh", "file of the mesh in the release, not scaled")
PREVIEW = text("preview", "file of a picture of the object in the release")

RELEASED_OBJECTS = schema(
    *OBJECTS,
    SPLIT,
    text(
        "family",
        "objects of a family have the same founder along the line of first parents; an object "
        "with unknown ancestors is a family of its own",
    ),
    boolean("in_evaluation_set", "whether the object is in the evaluation set"),
    text("gripper", "gripper that the object is scaled to"),
    real("opening", "opening of the gripper", "m"),
    real("scale_factor", "size of the scaled object / size of the mesh in the release"),
    *[field for field in ANTIPODAL_RATES if field.name not in ("id", "label")],
    integer("n_grasps", "number of grasps of the object in the release"),
    MESH,
    PREVIEW,
)

RELEASED_GRASPS = schema(
    *SIMULATED_GRASPS,
    *vector(
        "hand",
        "rotation of the hand in the frame of the scaled object (x closing axis, z approach), "
        "quaternion",
        parts=("qx", "qy", "qz", "qw"),
    ),
    SPLIT,
)

RELEASED_EVALUATION_SET = schema(*EVAL49, MESH, PREVIEW)

FILES = [
    Result("release/", "dataset that anyone can host; see docs/released.md"),
    Result(
        "release/data/objects.parquet",
        "objects; `objects/SPLIT.parquet` has those of each split",
        RELEASED_OBJECTS,
    ),
    Result(
        "release/data/grasps.parquet",
        "grasps of the released objects, in the frame of the object scaled to the gripper of the "
        "release; `grasps/SPLIT-NNNNN-of-NNNNN.parquet` has those of each split",
        RELEASED_GRASPS,
    ),
    Result(
        "release/data/evaluation_set.parquet",
        "evaluation set of the release",
        RELEASED_EVALUATION_SET,
    ),
]
