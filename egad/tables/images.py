"""Rendered images: one row per image, the pictures as PNG files."""

import pyarrow as pa

from egad.tables.columns import (
    FLOAT,
    INT,
    STRING,
    Result,
    binary,
    column,
    integer,
    pose,
    real,
    schema,
    text,
    values,
)

SINGLE = pa.float32()
FACTORS = values(
    "factors", "for each object: size / size of the mesh scaled to the gripper", of=FLOAT
)
LENS = [
    real("focal", "focal length", "px"),
    real("center_u", "column of the optical axis", "px"),
    real("center_v", "row of the optical axis", "px"),
]


def _listed(name: str, kind: pa.DataType, meaning: str, unit: str = "") -> pa.Field:
    return column(name, f"for each grasp: {meaning}", unit, kind=pa.list_(kind))


IMAGES = schema(
    integer("image", "number of the image; images of an object are consecutive"),
    text("scene", "single, packed or pile: how the objects lie"),
    text("id", "id of the object; for several objects, a name of the scene"),
    text("label", "label of the object; for several objects, a name of the scene"),
    text("split", "train, validation or test; the same for all images of an object"),
    integer("draws", "how many times poses and sizes were drawn for the image"),
    values("objects", "ids of the objects", of=STRING),
    FACTORS,
    values(
        "poses",
        "for each object: number of the stable pose, 0 = most probable; -1 = packed or dropped",
        of=INT,
    ),
    values(
        "placements",
        "for each object, 7 numbers: position (m) and quaternion (x, y, z, w) of the frame of "
        "the mesh in the world frame",
        of=FLOAT,
    ),
    binary("depth", "16-bit PNG: depth along the optical axis; 0 = no value", "0.1 mm"),
    binary("mask", "8-bit PNG: k = the k-th object, 0 = everything else"),
    integer("height", "height of the image", "px"),
    integer("width", "width of the image", "px"),
    *LENS,
    *pose("camera", "pose of the camera (x right, y down, z forward) in the world frame"),
    _listed("object", INT, "number of the object in the image, from 0"),
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
    _listed("quality", SINGLE, "robust quality; 0 if the grasp is not collision-free"),
    _listed("collision_free", pa.bool_(), "whether the hand touches nothing but the contacts"),
    _listed(
        "simulated_success",
        pa.bool_(),
        "whether the grasp held in simulation; no value if it was not simulated",
    ),
)
LISTS = IMAGES.names[IMAGES.names.index("object") :]
"""The columns that have one entry for each grasp."""

FILES = [
    Result(
        "D/images/G/images-N.parquet",
        "depth images with grasps (`targets.render`); see docs/vision.md",
        IMAGES,
    ),
    Result("D/images/G/card.md", "description of the images"),
    Result("D/images/G/openings.svg", "how far the hand opens for the good grasps in the images"),
]
