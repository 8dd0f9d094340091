"""Tables of the evaluation set: objects, files for printers and simulators, trials."""

import pyarrow as pa

from egad.tables.columns import (
    BOOL,
    CELLS,
    COMPLEXITY,
    FLOAT,
    GRASPABILITY,
    ID,
    INT,
    LABEL,
    QUALITY,
    ROBUST_QUALITY,
    ROBUST_SUCCESS_RATE,
    STRING,
    Result,
    column,
    optional,
    pose,
    vector,
)
from egad.tables.outcomes import (
    DETECTOR_FAILURES,
    EXECUTION,
    NOTED_BY_HAND,
    SIMULATION_FAILURES,
    SUCTION_FAILURES,
    listed,
)

VOLUME_ERROR = column("volume_error", FLOAT, "total volume of the parts / volume of the object - 1")
DEVIATION = column(
    "deviation", FLOAT, "largest distance that a part extends beyond the surface of the object", "m"
)
BURIED = column(
    "buried",
    FLOAT,
    "of the surface that fingers can touch, the fraction that lies deeper in a part than "
    "`bundle.deviation`",
)
DEVIATION_BOUND = column(
    "deviation_bound",
    FLOAT,
    "deviation that the parts keep to at 99 % of the surface that fingers can touch: larger than "
    "`bundle.deviation` if that would need more than `bundle.max_parts` parts; null for coacd",
    "m",
)
WITHIN = column(
    "within",
    BOOL,
    "whether the volume error is at most `bundle.volume_error`, and at most 1 % of the surface "
    "that fingers can touch is buried",
)
PLACE = column("label", STRING, "name in the evaluation set")
ENGINE = column("engine", STRING, "physics engine")
ERRORS = column(
    "errors",
    STRING,
    "errors of the robot cell (`trials.errors`, `clutter.errors`): a name, or their values",
)
CONTACT = column("contact", STRING, "what a contact on the way down means (`trials.contact`)")
FAILURE = optional(
    column("failure", STRING, "what the detector did wrong, with its traceback; empty if nothing")
)
SUCCESS = column("success", BOOL, "whether the object was still held at the end")

EVAL49 = pa.schema(
    [
        column(
            "label",
            STRING,
            "name in the evaluation set: A0 = easiest and simplest, or the name of an own mesh",
        ),
        ID,
        column("object_label", STRING, "label of the object in its dataset"),
        column("row", INT, "row of the coarse grid, 0 = easiest"),
        column("column", INT, "column of the coarse grid, 0 = simplest"),
        column(
            "borrowed",
            BOOL,
            "whether the object comes from a neighboring cell because this one had none",
        ),
        COMPLEXITY,
        GRASPABILITY,
        *CELLS,
        column("nearest", FLOAT, "distance to the nearest other object of the set"),
    ]
)

MANIFEST = pa.schema(
    [
        PLACE,
        ID,
        column("file", STRING, "STL file, coordinates in millimetres"),
        column("plate", INT, "number of the 3MF plate; null if it does not fit the bed"),
        *vector("place", "lowest corner of the object on the plate", "mm", "xy"),
        *vector("extents", "sides of the axis-aligned box as printed", "mm"),
        column("volume", FLOAT, "volume of the solid", "mm3"),
        column("filament", FLOAT, "estimated mass of the filament, without supports", "g"),
        column("pose", STRING, "how the pose was chosen: stable or overhang"),
        column("pose_probability", FLOAT, "probability of resting in this pose when dropped"),
        column("overhang", FLOAT, "area that needs support", "mm2"),
        column("contact", FLOAT, "area of the first layer", "mm2"),
        column("factor", FLOAT, "scaled size / size of the mesh in meshes/"),
        column("engraved", BOOL, "whether the label is engraved"),
        column("settings", STRING, "recommended print settings"),
        column("note", STRING, "what to know before printing; empty if nothing"),
    ]
)

BUNDLE = pa.schema(
    [
        column("label", STRING, "name in the evaluation set, and name of the folder of the object"),
        ID,
        column("method", STRING, "how the convex parts were made: cut or coacd"),
        column("parts", INT, "number of convex parts"),
        VOLUME_ERROR,
        DEVIATION,
        BURIED,
        DEVIATION_BOUND,
        WITHIN,
        column("poses", INT, "number of stable poses in poses.json"),
        column("volume", FLOAT, "volume of the solid", "m3"),
        column("density", FLOAT, "density that mass and inertia are computed with", "kg/m3"),
        column("friction", FLOAT, "sliding friction in URDF and MJCF"),
        column("mass", FLOAT, "mass", "kg"),
        *vector("com", "center of mass in the frame of the mesh", "m"),
        *vector(
            "inertia",
            "moment of inertia about the center of mass",
            "kg m2",
            ("xx", "yy", "zz", "xy", "xz", "yz"),
        ),
    ]
)

CONVEX_PARTS = pa.schema(
    [
        LABEL,
        ID,
        column("part", INT, "number of the part within its object"),
        column("vertices", pa.list_(FLOAT), "vertex coordinates, flat", "m"),
        column("faces", pa.list_(INT), "vertex indices of the triangles, flat"),
        VOLUME_ERROR,
        DEVIATION,
        BURIED,
        DEVIATION_BOUND,
        WITHIN,
    ]
)

RESULTS = pa.schema(
    [
        PLACE,
        column("id", STRING, "name of the object in its dataset; empty if not known"),
        column("attempt", INT, "number of the attempt"),
        SUCCESS,
        column("outcome", STRING, f"as in the table of simulated trials, {listed(NOTED_BY_HAND)}"),
        column("quality", FLOAT, "quality that the detector predicted; null if it gave none"),
        column("detector", STRING, "name of the grasp detector"),
        column(
            "initial_pose",
            STRING,
            "initial pose of the object, in hexadecimal; empty on a real robot",
        ),
        optional(column("engine", STRING, "physics engine; empty on a real robot")),
        optional(ERRORS),
        optional(CONTACT),
    ]
)

TRIALS = pa.schema(
    [
        PLACE,
        ID,
        column("attempt", INT, "number of the attempt"),
        column("seed", pa.string(), "seed of the attempt (hexadecimal)"),
        column("calibration", STRING, "seed of the calibration, shared by several attempts"),
        ERRORS,
        CONTACT,
        SUCCESS,
        column(
            "outcome",
            STRING,
            listed((*EXECUTION, *SUCTION_FAILURES, *SIMULATION_FAILURES, *DETECTOR_FAILURES)),
        ),
        column(
            "initial_pose",
            STRING,
            "how the attempt began: dropped, released by the hand (from_hand) or left",
        ),
        *pose(
            "initial",
            "initial pose of the object (center of mass, principal axes) in the world frame",
        ),
        *vector("grasp", "center of the grasp that was tried, world frame", "m"),
        column("angle", FLOAT, "angle of the closing axis about the vertical", "rad"),
        column("width", FLOAT, "opening that the detector asked for", "m"),
        column("depth", FLOAT, "how far the fingertips should reach below the center", "m"),
        column("quality", FLOAT, "quality that the detector predicted"),
        column("lifted", FLOAT, "height gained by the object at the end", "m"),
        *pose("end", "final pose of the object, in the frames of its initial pose"),
        column(
            "stopped", FLOAT, "distance before the grasp at which a contact stopped the hand", "m"
        ),
        column("parts", INT, "number of convex parts of the simulated object"),
        column("volume_error", FLOAT, "volume of the parts / volume of the object - 1"),
        ENGINE,
        FAILURE,
    ]
)

AGREEMENT = pa.schema(
    [
        PLACE,
        ID,
        column("grasp", INT, "number of the grasp on its object, as in the table of grasps"),
        QUALITY,
        ROBUST_QUALITY,
        ROBUST_SUCCESS_RATE,
        SUCCESS,
        column("outcome", STRING, listed((*EXECUTION, *SIMULATION_FAILURES))),
        column("lifted", FLOAT, "height gained by the object at the end", "m"),
        column("n_labelled", INT, "number of labelled grasps of the object"),
        column(
            "n_collision_free",
            INT,
            "number of collision-free labelled grasps of the object, from which the sample was "
            "drawn",
        ),
        ENGINE,
    ]
)

FILES = [
    Result(
        "D/convex_parts/G.parquet",
        "convex parts of the scaled objects (for a release, and exports of all objects)",
        CONVEX_PARTS,
    ),
    Result("D/eval49.parquet", "evaluation set", EVAL49),
    Result("D/eval49/README.md", "datasheet of the evaluation set, with how to report results"),
    Result(
        "D/eval49/contact-sheet.pdf",
        "pictures of the objects of the evaluation set, with names and sizes",
    ),
    Result("D/eval49/trials.csv", "empty table to fill in with attempts of a real robot"),
    Result("D/print/G/LABEL_RULE_OPENING.stl", "evaluation set to print, in millimetres"),
    Result("D/print/G/plate-N.3mf", "evaluation set to print, on the plates of a printer"),
    Result("D/print/G/manifest.parquet", "what is on each plate", MANIFEST),
    Result("D/bundle/G/LABEL/", "evaluation set for simulators; see docs/bundle.md"),
    Result("D/bundle/G/README.md", "description of the files in this folder"),
    Result(
        "D/bundle/G/bundle.parquet",
        "objects of the evaluation set for simulators: parts, masses, inertia",
        BUNDLE,
    ),
    Result("D/trials/G/P.parquet", "simulated trials, one attempt per row", TRIALS),
    Result(
        "D/agreement/G.parquet",
        "sample of the labelled grasps, executed in simulation (`targets.agreement`)",
        AGREEMENT,
    ),
]
