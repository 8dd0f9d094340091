"""What a dataset release contains: the tables and the other files, each with its meaning."""

from egad.exchange.release.croissant import Files, Table
from egad.tables.release import RELEASED_EVALUATION_SET, RELEASED_GRASPS, RELEASED_OBJECTS

PARQUET = "application/x-parquet"
ABSTRACT = (
    "Closed objects from simple to complex and from easy to hard to grasp, and parallel-jaw grasps "
    "on them that were labelled in simulation."
)
# Properties of Croissant RAI 1.0, https://docs.mlcommons.org/croissant/docs/croissant-rai-spec.html
RAI = {
    "rai:dataCollection": "An evolutionary search made the objects; no objects, images or data of "
    "people were collected.",
    "rai:dataCollectionType": ["Software Collection", "Others"],
    "rai:dataAnnotationProtocol": "A physics engine closed the fingers on the floating object, "
    "shook it and lifted it; a grasp succeeds if both fingers still hold the object at the end.",
    "rai:machineAnnotationTools": ["MuJoCo or PyBullet, as the column simulated_engine says"],
    "rai:dataLimitations": [
        "Grasps, labels and scales are for one gripper, friction and density.",
        "Labels were simulated with rigid bodies, and with convex parts in place of the true "
        "surface. They are not trials of a real robot.",
        "Only collision-free grasps were simulated, so the share that held is not that of random "
        "grasps.",
    ],
    "rai:dataBiases": [
        "Objects are abstract shapes of one uniform material, spread evenly over complexity and "
        "difficulty. They do not follow the frequencies of objects in homes or factories."
    ],
    "rai:dataUseCases": ["Training, validation and testing of grasp detectors for parallel jaws."],
    "rai:dataSocialImpact": "Robots that grasp more reliably can replace manual labor.",
    "rai:personalSensitiveInformation": ["None."],
}
TABLES = (
    Table(
        "objects",
        "one row per object: measures, mass properties, scale factor, split",
        "data/objects.parquet",
        PARQUET,
        RELEASED_OBJECTS,
        ("id",),
    ),
    Table(
        "grasps",
        "one row per grasp with a simulated label",
        "data/grasps.parquet",
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
    Files("splits", "objects and grasps again, in files by split", "data/*/*.parquet", PARQUET),
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
