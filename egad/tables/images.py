"""Rendered images: one row per image, the pictures as PNG files."""

import pyarrow as pa

from egad.tables.columns import BINARY, FLOAT, ID, INT, LABEL, STRING, column, pose

SINGLE = pa.float32()


def _listed(name: str, kind: pa.DataType, meaning: str, unit: str = "") -> pa.Field:
    return column(name, pa.list_(kind), f"of each grasp: {meaning}", unit)


IMAGES = pa.schema(
    [
        column("image", INT, "number of the image; images of an object are consecutive"),
        ID,
        LABEL,
        column("split", STRING, "train, validation or test; the same for all images of an object"),
        column("pose", pa.int16(), "number of the stable pose, 0 = most probable"),
        column("depth", BINARY, "16-bit PNG: depth along the optical axis; 0 = no value", "0.1 mm"),
        column("mask", BINARY, "8-bit PNG: 255 = object, 0 = everything else"),
        column("height", INT, "height of the image", "px"),
        column("width", INT, "width of the image", "px"),
        column("focal", FLOAT, "focal length", "px"),
        column("center_u", FLOAT, "column of the optical axis", "px"),
        column("center_v", FLOAT, "row of the optical axis", "px"),
        *pose("camera", "camera (x right, y down, z forward) in the world frame"),
        *pose("object", "frame of the scaled mesh in the world frame"),
        _listed("grasp", INT, "number of the grasp in the table of grasps"),
        _listed("u", SINGLE, "column of the center; the middle of the first pixel is 0", "px"),
        _listed("v", SINGLE, "row of the center; the middle of the first pixel is 0", "px"),
        _listed(
            "angle",
            SINGLE,
            "closing axis, counterclockwise in the image from its x axis (right), in [-pi/2, pi/2)",
            "rad",
        ),
        _listed("opening", SINGLE, "opening of the hand, at the depth of the center", "px"),
        _listed("depth_center", SINGLE, "depth of the center along the optical axis", "m"),
        _listed("quality", SINGLE, "robust quality of the labelled grasp"),
        _listed(
            "collision_free",
            pa.bool_(),
            "whether the hand touches neither the object nor the table",
        ),
        _listed(
            "simulated_success",
            pa.bool_(),
            "whether it lifted the object in simulation; null if it was not simulated",
        ),
    ]
)
