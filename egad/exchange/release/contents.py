"""What a release contains."""

CONTENTS = {
    "data/objects.parquet": "one row per object: measures, mass properties, scale factor, split",
    "data/grasps.parquet": "one row per grasp with a simulated label",
    "data/evaluation_set.parquet": "one row per object of the evaluation set",
    "data/*/*.parquet": "objects and grasps again, in files by split",
    "meshes/*.glb": "closed surface of each object, not scaled",
    "previews/*.png": "picture of each object",
    "archives/*.zip": "objects for simulators, scaled to the gripper: a folder each with "
    "description, convex parts, mass, friction, poses at rest",
    "networks/*/weights.safetensors": "grasp networks that egad ships as detectors of the same "
    "names, with their model cards",
    "index.html": "page to view the objects in a browser, with its data in the folder `gallery`",
}
"""Meanings of the files, or of their rows, by patterns of their names."""
