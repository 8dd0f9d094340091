"""Tables of the evaluation set: objects, files for printers and simulators, trials."""

import pyarrow as pa

from egad.outcomes import DETECTOR_FAILURES, EXECUTION, NOTED_BY_HAND, SIMULATION_FAILURES, listed
from egad.tables.columns import (
    BOOL,
    CELLS,
    COMPLEXITY,
    DIFFICULTY,
    FLOAT,
    HELD,
    ID,
    INT,
    QUALITY,
    ROBUST_QUALITY,
    STRING,
    column,
    pose,
    vector,
)

PLACE = column("label", STRING, "name in the evaluation set")
SUCCESS = column("success", BOOL, "whether the object was still held at the end")

EVAL49 = pa.schema(
    [
        column("label", STRING, "name in the evaluation set, A0 = easiest and simplest"),
        ID,
        column("object_label", STRING, "label of the object in its dataset"),
        column("row", INT, "row of the coarse grid, 0 = easiest"),
        column("column", INT, "column of the coarse grid, 0 = simplest"),
        column("borrowed", BOOL, "whether it lies in a cell beside this one, which had no object"),
        COMPLEXITY,
        DIFFICULTY,
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
        *vector("place", "lowest corner on the plate", "mm", "xy"),
        *vector("extents", "sides of the axis-aligned box as printed", "mm"),
        column("volume", FLOAT, "volume of the solid", "mm3"),
        column("filament", FLOAT, "mass of the filament, without supports, estimated", "g"),
        column("pose", STRING, "how the pose was chosen: stable or overhang"),
        column("pose_probability", FLOAT, "chance of coming to rest in this pose when dropped"),
        column("overhang", FLOAT, "area that needs support", "mm2"),
        column("contact", FLOAT, "area of the first layer", "mm2"),
        column("factor", FLOAT, "scaled size / size in meshes/"),
        column("engraved", BOOL, "whether its label is cut into it"),
        column("settings", STRING, "how to print it"),
        column("note", STRING, "what to know before printing; empty if nothing"),
    ]
)

BUNDLE = pa.schema(
    [
        column("label", STRING, "name in the evaluation set, and of its folder"),
        ID,
        column("method", STRING, "how the convex parts were made: cut or coacd"),
        column("parts", INT, "convex parts"),
        column("volume_error", FLOAT, "volume of the parts together / volume of the object - 1"),
        column("deviation", FLOAT, "how far the parts stick out of the object at most", "m"),
        column("within", BOOL, "whether the volume error is within the bound of the settings"),
        column("poses", INT, "poses at rest in poses.json"),
        column("volume", FLOAT, "volume of the solid", "m3"),
        column("density", FLOAT, "density that mass and inertia are for", "kg/m3"),
        column("friction", FLOAT, "sliding friction in the descriptions"),
        column("mass", FLOAT, "mass", "kg"),
        *vector("com", "centre of mass in the frame of the mesh", "m"),
        *vector(
            "inertia",
            "moment of inertia about the centre of mass",
            "kg m2",
            ("xx", "yy", "zz", "xy", "xz", "yz"),
        ),
    ]
)

RESULTS = pa.schema(
    [
        PLACE,
        column("id", STRING, "name of the object within its dataset; empty on a real robot"),
        column("attempt", INT, "number of the attempt"),
        SUCCESS,
        column("outcome", STRING, f"as in the table of simulated trials, {listed(NOTED_BY_HAND)}"),
        column("quality", FLOAT, "quality that the detector gave; null if it gave none"),
        column("detector", STRING, "name of the grasp detector"),
        column(
            "start", STRING, "pose that the object fell from, in hexadecimal; empty on a real robot"
        ),
    ]
)

TRIALS = pa.schema(
    [
        PLACE,
        ID,
        column("attempt", INT, "number of the attempt"),
        column("seed", pa.string(), "seed of the attempt (hexadecimal)"),
        SUCCESS,
        column(
            "outcome",
            STRING,
            listed((*EXECUTION, *SIMULATION_FAILURES, *DETECTOR_FAILURES)),
        ),
        column("begun", STRING, "how the object came to lie there: dropped, from_hand or left"),
        *pose("start", "where the object fell from: centre of mass and principal axes, world"),
        *vector("grasp", "grasp centre chosen by the detector, world frame", "m"),
        column("angle", FLOAT, "angle of the closing axis about the vertical", "rad"),
        column("width", FLOAT, "opening that the detector asked for", "m"),
        column("depth", FLOAT, "how far the fingertips were to reach below the centre", "m"),
        column("quality", FLOAT, "quality that the detector gave"),
        column("lifted", FLOAT, "height gained by the object at the end", "m"),
        *pose("end", "where the object was at the end, as its start"),
        column("parts", INT, "convex parts of the simulated object"),
        column("volume_error", FLOAT, "volume of the parts / volume of the object - 1"),
    ]
)

AGREEMENT = pa.schema(
    [
        PLACE,
        ID,
        column("grasp", INT, "number of the grasp on its object, as in the table of grasps"),
        QUALITY,
        ROBUST_QUALITY,
        HELD,
        SUCCESS,
        column("outcome", STRING, listed((*EXECUTION, *SIMULATION_FAILURES))),
        column("lifted", FLOAT, "height gained by the object at the end", "m"),
        column("labelled", INT, "labelled grasps of the object"),
        column("free", INT, "of these, free of collision: what the sample was drawn from"),
    ]
)
