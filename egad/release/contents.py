"""What a dataset release contains: the tables and the other files, each with its meaning."""

from egad.release.croissant import Files, Table
from egad.tables.release import RELEASED_EVALUATION_SET, RELEASED_GRASPS, RELEASED_OBJECTS

PARQUET = "application/x-parquet"
ABSTRACT = (
    "Closed objects from simple to complex and from easy to hard to grasp, and parallel-jaw grasps "
    "on them that were labelled in simulation."
)
TABLES = (
    Table(
        "objects",
        "one row per object: measures, mass properties, scale factor, split",
        "data/objects/*.parquet",
        PARQUET,
        RELEASED_OBJECTS,
        ("id",),
    ),
    Table(
        "grasps",
        "one row per grasp with a simulated label",
        "data/grasps/*.parquet",
        PARQUET,
        RELEASED_GRASPS,
        ("id", "grasp"),
    ),
    Table(
        "evaluation_set",
        "one row per object of the evaluation set",
        "data/evaluation_set.parquet",
        PARQUET,
        RELEASED_EVALUATION_SET,
        ("label",),
    ),
)
OTHER_FILES = (
    Files(
        "meshes", "closed surface of each object, not scaled", "meshes/*.glb", "model/gltf-binary"
    ),
    Files("previews", "picture of each object", "previews/*.png", "image/png"),
    Files(
        "archives",
        "objects for simulators, scaled to the gripper: a folder each with description, convex "
        "parts, mass, friction, poses at rest",
        "archives/*.zip",
        "application/zip",
    ),
    Files(
        "network",
        "grasp networks that egad ships as detectors of the same names, with their model cards",
        "networks/*/weights.safetensors",
        "application/octet-stream",
    ),
    Files(
        "gallery",
        "page to view the objects in a browser, with its data in the folder `gallery`",
        "index.html",
        "text/html",
    ),
)
