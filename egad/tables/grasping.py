"""Tables of a gripper: grasps, what became of candidates, and the scales of the objects."""

import pyarrow as pa

from egad.tables.columns import (
    BOOL,
    FLOAT,
    HELD,
    ID,
    INT,
    LABEL,
    QUALITY,
    ROBUST_QUALITY,
    STRING,
    column,
    vector,
)

GRASPS = pa.schema(
    [
        ID,
        LABEL,
        column("grasp", INT, "number of the grasp on its object"),
        *vector("center", "midpoint of the contacts", "m"),
        *vector("axis", "unit vector from the first contact to the second"),
        *vector("approach", "unit vector along which the hand moves towards the object"),
        column("width", FLOAT, "distance of the contacts", "m"),
        column(
            "needed_opening",
            FLOAT,
            "least distance of the fingers, whole boxes, at which both stand beside the object; "
            "may be more than the gripper has",
            "m",
        ),
        *vector("contact0", "first contact", "m"),
        *vector("contact1", "second contact", "m"),
        *vector("normal0", "outward unit normal at the first contact"),
        *vector("normal1", "outward unit normal at the second contact"),
        QUALITY,
        ROBUST_QUALITY,
        column("robust_quality_std", FLOAT, "standard deviation over disturbed copies"),
        HELD,
        column(
            "fits",
            BOOL,
            "whether the open hand touches nothing at the grasp, at the best of the approach "
            "angles tried",
        ),
        column(
            "collision_free",
            BOOL,
            "whether the open hand touches nothing at the grasp nor on its straight way in, at the "
            "best of the approach angles tried",
        ),
        column("angles_fit", INT, "approaches around the axis, of those tried, that fit"),
        column("angles_free", INT, "approaches around the axis, of those tried, free of collision"),
    ]
)

TALLY = pa.schema(
    [
        ID,
        LABEL,
        column("wanted", INT, "grasps wanted"),
        column("tried", INT, "candidates tried"),
        column("too_wide", INT, "of these, without opposite surface within the opening"),
        column("not_antipodal", INT, "of these, whose second contact faces away from the axis"),
        column("blocked", INT, "of these, with something in the way of the open fingers"),
        column("too_close", INT, "of these, too much like a grasp found before"),
        column("surplus", INT, "of these, found when there were enough"),
        column("grasps", INT, "of these, kept: the rows in the table of grasps"),
        column("slipped", INT, "of the grasps, without quality: the axis leaves a friction cone"),
        column("without_room", INT, "of the grasps, that the hand fits at from no angle"),
        column("without_way", INT, "of the grasps, that it fits at but cannot come to"),
    ]
)

SCALES = pa.schema(
    [
        LABEL,
        column("rule", STRING, "scale rule"),
        column("opening", FLOAT, "opening of the gripper", "m"),
        column("factor", FLOAT, "scaled size / size before"),
        *vector("before", "sides of the minimum-volume box before, ascending", "m", "123"),
        *vector("after", "sides of the minimum-volume box after, ascending", "m", "123"),
        column(
            "fit_before",
            FLOAT,
            "part of the surface, before, with opposite surface straight along the normal within "
            "the opening",
        ),
        column("fit_after", FLOAT, "the same after"),
        column("file", STRING, "the scaled mesh"),
    ]
)

SIZE_EFFECT = pa.schema(
    [
        column("name", STRING, "name in the evaluation set, or of the mesh file"),
        column("fraction", FLOAT, "smallest side of the minimum-volume box over the opening"),
        column("repeat", INT, "number of the repetition with other random numbers"),
        column("candidates", INT, "candidate axes drawn"),
        column("possible", INT, "those that the open fingers reach and hold, alike or not"),
        column("grasps", INT, "grasps that the percentiles were taken from"),
        column("percentile", FLOAT, "percentile of the quality", "%"),
        column("quality", FLOAT, "Ferrari-Canny quality there; null without any grasp"),
    ]
)
