"""Scenes for training: what cameras see of several objects, and grasps labelled in simulation."""

import pyarrow as pa

from egad.tables.columns import BINARY, BOOL, FLOAT, INT, POSE_PARTS, STRING, Result, column
from egad.tables.images import FACTORS, LENS

SCENES = pa.schema(
    [
        column("scene", INT, "number of the scene"),
        column("kind", STRING, "packed or pile: how the objects lie"),
        column("split", STRING, "train, validation or test; the same for all objects of the scene"),
        column("objects", pa.list_(STRING), "ids of the objects that lie in the workspace"),
        FACTORS,
        column(
            "placements",
            pa.list_(FLOAT),
            "for each object, 7 numbers: position (m) and quaternion (x, y, z, w) of the frame of "
            "the mesh in the world frame; the table is z = 0",
        ),
        column("noise", STRING, "noise in the depth images, as in `clutter.noise`"),
        column("height", INT, "height of the images", "px"),
        column("width", INT, "width of the images", "px"),
        *LENS,
        column(
            "cameras",
            pa.list_(FLOAT),
            "for each view, 7 numbers: position (m) and quaternion (x, y, z, w) of the camera (x "
            "right, y down, z forward) in the world frame",
        ),
        column(
            "depth",
            pa.list_(BINARY),
            "for each view, a 16-bit PNG: depth along the optical axis; 0 = no value",
            "0.1 mm",
        ),
        column(
            "mask",
            pa.list_(BINARY),
            "for each view, an 8-bit PNG: k = the k-th object, 0 = everything else",
        ),
    ]
)

HAND = [
    *(column(name, FLOAT, f"origin of the hand, {name}", "m") for name in POSE_PARTS[:3]),
    *(column(name, FLOAT, f"rotation of the hand, quaternion, {name}") for name in POSE_PARTS[3:]),
]
SCENE_GRASPS = pa.schema(
    [
        column("scene", INT, "number of the scene"),
        column(
            "object",
            INT,
            "number of the object in the scene whose surface the grasp was sampled from",
        ),
        column("id", STRING, "id of that object"),
        *HAND,
        column(
            "width",
            FLOAT,
            "distance between the finger pads after the lift; no value if the grasp failed",
            "m",
        ),
        column("success", BOOL, "whether the hand lifted an object at one of the yaws tried"),
        column(
            "yaws",
            pa.list_(BOOL),
            "whether the hand lifted an object at each of the n yaws tried: the k-th, from 0, is "
            "this pose rotated by k / n of half a turn about the approach; half a turn gives the "
            "same grasp",
        ),
        column("outcome", STRING, "outcome of the attempt at this pose"),
    ]
)

FILES = [
    Result(
        "D/scenes/G/scenes-N.parquet",
        "packed and piled objects with depth images (`targets.scenes`); see docs/vision.md",
        SCENES,
    ),
    Result(
        "D/scenes/G/grasps-N.parquet",
        "grasps in the scenes, labelled by simulation: position (x, y, z) and quaternion (qx to "
        "qw) of the hand in the world frame; its origin lies between the fingertips, x is the "
        "closing axis, z the approach",
        SCENE_GRASPS,
    ),
    Result("D/scenes/G/card.md", "description of the scenes"),
    Result("D/scenes/G/scene.png", "one of the scenes, with some of its grasps"),
    Result("D/scenes/G/rejected.parquet", "objects that are in no scene, with reasons"),
]
