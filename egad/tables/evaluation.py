"""Tables of the evaluation set: objects, files for printers and simulators, trials."""

from egad.tables.columns import (
    CELLS,
    COMPLEXITY,
    FLOAT,
    GRASPABILITY,
    ID,
    INERTIA_COLUMNS,
    INT,
    LABEL,
    QUALITY,
    ROBUST_QUALITY,
    ROBUST_SUCCESS_RATE,
    Result,
    boolean,
    integer,
    optional,
    pose,
    real,
    schema,
    text,
    values,
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

VOLUME_ERROR = real("volume_error", "total volume of the parts / volume of the object - 1")
DEVIATION = real(
    "deviation", "largest distance that a part extends beyond the surface of the object", "m"
)
BURIED = real(
    "buried",
    "of the surface that fingers can touch, the fraction that lies deeper in a part than "
    "`bundle.deviation`",
)
DEVIATION_BOUND = real(
    "deviation_bound",
    "deviation that the parts keep to at 99 % of the surface that fingers can touch: larger than "
    "`bundle.deviation` if that would need more than `bundle.max_parts` parts; null for coacd",
    "m",
)
WITHIN = boolean(
    "within",
    "whether the volume error is at most `bundle.volume_error`, and at most 1 % of the surface "
    "that fingers can touch is buried",
)
PLACE = text("label", "name in the evaluation set")
ENGINE = text("engine", "physics engine")
PLATFORM = text(
    "platform", "version of the engine, processor and libraries, which decide the last bits"
)
ERRORS = text(
    "errors",
    "errors of the robot cell (`trials.errors`, `clutter.errors`): a name, or their values",
)
CONTACT = text("contact", "what a contact on the way down means (`trials.contact`)")
FAILURE = optional(
    text("failure", "what the detector did wrong, with its traceback; empty if nothing")
)
SUCCESS = boolean("success", "whether the object was still held at the end")

EVAL49 = schema(
    text(
        "label", "name in the evaluation set: A0 = easiest and simplest, or the name of an own mesh"
    ),
    ID,
    text("object_label", "label of the object in its dataset"),
    integer("row", "row of the coarse grid, 0 = easiest"),
    integer("column", "column of the coarse grid, 0 = simplest"),
    boolean(
        "borrowed", "whether the object comes from a neighboring cell because this one had none"
    ),
    COMPLEXITY,
    GRASPABILITY,
    *CELLS,
    real("nearest", "distance to the nearest other object of the set"),
)

MANIFEST = schema(
    PLACE,
    ID,
    text("file", "STL file, coordinates in millimetres"),
    integer("plate", "number of the 3MF plate; null if it does not fit the bed"),
    *vector("place", "lowest corner of the object on the plate", "mm", "xy"),
    *vector("extents", "sides of the axis-aligned box as printed", "mm"),
    real("volume", "volume of the solid", "mm3"),
    real("filament", "estimated mass of the filament, without supports", "g"),
    text("pose", "how the pose was chosen: stable or overhang"),
    real("pose_probability", "probability of resting in this pose when dropped"),
    real("overhang", "area that needs support", "mm2"),
    real("contact", "area of the first layer", "mm2"),
    real("factor", "scaled size / size of the mesh in meshes/"),
    boolean("engraved", "whether the label is engraved"),
    text("settings", "recommended print settings"),
    text("note", "what to know before printing; empty if nothing"),
)

BUNDLE = schema(
    text("label", "name in the evaluation set, and name of the folder of the object"),
    ID,
    text("method", "how the convex parts were made: cut or coacd"),
    integer("parts", "number of convex parts"),
    VOLUME_ERROR,
    DEVIATION,
    BURIED,
    DEVIATION_BOUND,
    WITHIN,
    integer("poses", "number of stable poses in poses.json"),
    real("volume", "volume of the solid", "m3"),
    real("density", "density that mass and inertia are computed with", "kg/m3"),
    real("friction", "sliding friction in URDF and MJCF"),
    real("mass", "mass", "kg"),
    *vector("com", "center of mass in the frame of the mesh", "m"),
    *INERTIA_COLUMNS,
)

CONVEX_PARTS = schema(
    LABEL,
    ID,
    integer("part", "number of the part within its object"),
    values("vertices", "vertex coordinates, flat", "m", of=FLOAT),
    values("faces", "vertex indices of the triangles, flat", of=INT),
    VOLUME_ERROR,
    DEVIATION,
    BURIED,
    DEVIATION_BOUND,
    WITHIN,
)

RESULTS = schema(
    PLACE,
    text("id", "name of the object in its dataset; empty if not known"),
    integer("attempt", "number of the attempt"),
    SUCCESS,
    text("outcome", f"as in the table of simulated trials, {listed(NOTED_BY_HAND)}"),
    real("quality", "quality that the detector predicted; null if it gave none"),
    text("detector", "name of the grasp detector"),
    text("initial_pose", "initial pose of the object, in hexadecimal; empty on a real robot"),
    optional(text("engine", "physics engine; empty on a real robot")),
    optional(ERRORS),
    optional(CONTACT),
)

TRIALS = schema(
    PLACE,
    ID,
    integer("attempt", "number of the attempt"),
    text("seed", "seed of the attempt (hexadecimal)"),
    text("calibration", "seed of the calibration, shared by several attempts"),
    ERRORS,
    CONTACT,
    SUCCESS,
    text(
        "outcome", listed((*EXECUTION, *SUCTION_FAILURES, *SIMULATION_FAILURES, *DETECTOR_FAILURES))
    ),
    text(
        "initial_pose", "how the attempt began: dropped, released by the hand (from_hand) or left"
    ),
    *pose(
        "initial", "initial pose of the object (center of mass, principal axes) in the world frame"
    ),
    *vector("grasp", "center of the grasp that was tried, world frame", "m"),
    real("angle", "angle of the closing axis about the vertical", "rad"),
    real("width", "opening that the detector asked for", "m"),
    real("depth", "how far the fingertips should reach below the center", "m"),
    real("quality", "quality that the detector predicted"),
    real("lifted", "height gained by the object at the end", "m"),
    *pose("end", "final pose of the object, in the frames of its initial pose"),
    real("stopped", "distance before the grasp at which a contact stopped the hand", "m"),
    integer("parts", "number of convex parts of the simulated object"),
    real("volume_error", "volume of the parts / volume of the object - 1"),
    ENGINE,
    PLATFORM,
    FAILURE,
)

AGREEMENT = schema(
    PLACE,
    ID,
    integer("grasp", "number of the grasp on its object, as in the table of grasps"),
    QUALITY,
    ROBUST_QUALITY,
    ROBUST_SUCCESS_RATE,
    SUCCESS,
    text("outcome", listed((*EXECUTION, *SIMULATION_FAILURES))),
    real("lifted", "height gained by the object at the end", "m"),
    integer("n_labelled", "number of labelled grasps of the object"),
    integer(
        "n_collision_free",
        "number of collision-free labelled grasps of the object, from which the sample was drawn",
    ),
    ENGINE,
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
