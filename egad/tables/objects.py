"""Tables of objects: what they are, where they lie in the space, and which were left out."""

import pyarrow as pa

from egad.tables.columns import (
    BINARY,
    BOOL,
    CELL_CONFIDENCE,
    CELLS,
    COMPLEXITY,
    DIVERSITY,
    FLOAT,
    GRASPABILITY,
    GRASPABILITY_STD,
    ID,
    INT,
    LABEL,
    RAW_COMPLEXITY,
    STRING,
    Result,
    column,
    vector,
)

_SHELL = column(
    "shell_thickness",
    FLOAT,
    "wall thickness that an open surface was given; 0 if the surface was closed",
    "m",
)
_DROPPED = [
    column("dropped_bodies", INT, "number of bodies, closed or open, that repair left out"),
    column(
        "dropped_volume",
        FLOAT,
        "volume of the bodies left out / volume of all bodies, with holes closed; 0 if those left "
        "out have no volume",
    ),
]
_GRAPH = column("graph", BINARY, "packed Reeb graph of the object")
_GRASPS = column("grasps", INT, "number of grasps that the graspability was computed from")
SOLIDS = pa.schema(
    [
        ID,
        COMPLEXITY,
        RAW_COMPLEXITY,
        GRASPABILITY,
        GRASPABILITY_STD,
        CELL_CONFIDENCE,
        _GRASPS,
        column(
            "archive_graspability", FLOAT, "graspability measured during evolution, for selection"
        ),
        column("volume", FLOAT, "volume of the solid", "m3"),
        column("area", FLOAT, "surface area", "m2"),
        column("watertight", BOOL, "whether every edge has exactly two faces"),
        column("repaired", BOOL, "whether repair changed the mesh beyond merging vertices"),
        _SHELL,
        *_DROPPED,
        *vector("extents", "sides of the axis-aligned box", "m"),
        *vector("com", "center of mass", "m"),
        column("mass", FLOAT, "mass at the configured density", "kg"),
        *vector(
            "inertia",
            "moment of inertia about the center of mass",
            "kg m2",
            ("xx", "yy", "zz", "xy", "xz", "yz"),
        ),
        column("vertices", pa.list_(FLOAT), "vertex coordinates, flat", "m"),
        column("faces", pa.list_(INT), "vertex indices of the triangles, flat"),
        _GRAPH,
    ]
)
GRAPHS = pa.schema([ID, _GRAPH])

_INTERNAL = {"vertices", "faces", "graph"}
OBJECTS = pa.schema(
    [
        ID,
        LABEL,
        *[field for field in SOLIDS if field.name not in _INTERNAL | {"id"}],
        *CELLS,
        DIVERSITY,
    ]
)

GRASPABILITIES = pa.schema([LABEL, GRASPABILITY, GRASPABILITY_STD, _GRASPS])

REJECTED = pa.schema(
    [
        column("id", STRING, "object or file that was rejected"),
        column("stage", STRING, "stage that rejected it"),
        column("reason", STRING, "why it was rejected"),
    ]
)

_REASON = column("reason", STRING, "why it could not be measured; empty if it was")
MEASURED = pa.schema(
    [
        column("name", STRING, "name of the mesh file"),
        COMPLEXITY,
        RAW_COMPLEXITY,
        GRASPABILITY,
        GRASPABILITY_STD,
        *CELLS,
        CELL_CONFIDENCE,
        _GRASPS,
        column("longest_side", FLOAT, "longest side of the axis-aligned box", "m"),
        column("rule", STRING, "scale rule; the cells of the map use `exact`"),
        column("opening", FLOAT, "widest opening of the gripper", "m"),
        column("factor", FLOAT, "size at which grasps were sampled / size of the mesh"),
        *vector("grasped", "side of the box at that size, ascending", "m", "123"),
        column("repaired", BOOL, "whether repair changed the mesh beyond merging vertices"),
        _SHELL,
        *_DROPPED,
        _REASON,
    ]
)

LOCATED = pa.schema(
    [
        column("name", STRING, "name of the mesh file"),
        COMPLEXITY,
        GRASPABILITY,
        GRASPABILITY_STD,
        *CELLS,
        CELL_CONFIDENCE,
        column("complexity_percentile", FLOAT, "percentage of the objects that are simpler", "%"),
        column("difficulty_percentile", FLOAT, "percentage of the objects that are easier", "%"),
        column("diversity", FLOAT, "mean distance to the nearest objects"),
        column("nearest", pa.list_(STRING), "nearest objects, nearest first"),
        column("distances", pa.list_(FLOAT), "distances to the nearest objects"),
        _SHELL,
        *_DROPPED,
        _REASON,
    ]
)

COMPARISON = pa.schema(
    [
        column("dataset", STRING, "name of the dataset"),
        column("objects", INT, "number of objects"),
        column(
            "coverage",
            FLOAT,
            "archive coverage: fraction of the slots of all cells that are filled",
        ),
        column(
            "attainable_coverage",
            FLOAT,
            "fraction of the slots that are filled, without the easiest rows, where no object is "
            "expected (studies/search/README.md)",
        ),
        column("filled_cells", FLOAT, "fraction of the cells that hold at least one object"),
        column("diversity_min", FLOAT, "diversity of the least diverse object"),
        column("diversity_max", FLOAT, "diversity of the most diverse object"),
        column("diversity_mean", FLOAT, "mean diversity"),
    ]
)

FILES = [
    Result("comparison.parquet", "coverage and diversity of all datasets", COMPARISON),
    Result("comparison.svg", "small map of each dataset"),
    Result("D/objects.parquet", "repaired and measured objects", OBJECTS),
    Result("D/rejected.parquet", "rejected objects, with reasons", REJECTED),
    Result("D/meshes/LABEL.obj", "meshes of the objects, in metres"),
    Result(
        "D/graspability/G.parquet",
        "measures of the objects for gripper G (`targets.graspability`)",
        GRASPABILITIES,
    ),
    Result("D/rescaled/G/rejected.parquet", "objects that cannot be scaled", REJECTED),
    Result("D/grasps/G.rejected.parquet", "objects without grasps", REJECTED),
    Result(
        "D/eval49.rejected.parquet",
        "objects that were left out of the evaluation set: those that cannot be printed, and own "
        "meshes whose cell has another",
        REJECTED,
    ),
    Result(
        "D/bundle/G/rejected.parquet",
        "objects that are not in the evaluation set for simulators",
        REJECTED,
    ),
    Result("D/images/G/rejected.parquet", "objects without images", REJECTED),
]


def rejection(object_id: str, stage: str, reason: object) -> dict[str, str]:
    """A row of `REJECTED`."""
    return {"id": object_id, "stage": stage, "reason": str(reason)}
