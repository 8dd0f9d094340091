"""Scenes for training: what cameras see of several objects, and grasps labelled in simulation."""

from egad.tables.columns import (
    BINARY,
    BOOL,
    FLOAT,
    POSE_PARTS,
    STRING,
    Result,
    boolean,
    integer,
    real,
    schema,
    text,
    values,
)
from egad.tables.images import FACTORS, LENS

SCENES = schema(
    integer("scene", "number of the scene"),
    text("kind", "packed or pile: how the objects lie"),
    text("split", "train, validation or test; the same for all objects of the scene"),
    values("objects", "ids of the objects that lie in the workspace", of=STRING),
    FACTORS,
    values(
        "placements",
        "for each object, 7 numbers: position (m) and quaternion (x, y, z, w) of the frame of "
        "the mesh in the world frame; the table is z = 0",
        of=FLOAT,
    ),
    text("noise", "noise in the depth images, as in `clutter.noise`"),
    integer("height", "height of the images", "px"),
    integer("width", "width of the images", "px"),
    *LENS,
    values(
        "cameras",
        "for each view, 7 numbers: position (m) and quaternion (x, y, z, w) of the camera (x "
        "right, y down, z forward) in the world frame",
        of=FLOAT,
    ),
    values(
        "depth",
        "for each view, a 16-bit PNG: depth along the optical axis; 0 = no value",
        "0.1 mm",
        of=BINARY,
    ),
    values(
        "mask", "for each view, an 8-bit PNG: k = the k-th object, 0 = everything else", of=BINARY
    ),
)

HAND = [
    *(real(name, f"origin of the hand, {name}", "m") for name in POSE_PARTS[:3]),
    *(real(name, f"rotation of the hand, quaternion, {name}") for name in POSE_PARTS[3:]),
]
SCENE_GRASPS = schema(
    integer("scene", "number of the scene"),
    integer("object", "number of the object in the scene whose surface the grasp was sampled from"),
    text("id", "id of that object"),
    *HAND,
    real(
        "width",
        "distance between the finger pads after the lift; no value if the grasp failed",
        "m",
    ),
    boolean("success", "whether the hand lifted an object at one of the yaws tried"),
    values(
        "yaws",
        "whether the hand lifted an object at each of the n yaws tried: the k-th, from 0, is "
        "this pose rotated by k / n of half a turn about the approach; half a turn gives the "
        "same grasp",
        of=BOOL,
    ),
    text("outcome", "outcome of the attempt at this pose"),
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
