"""Tables of objects: what they are, where they lie in the space, and which were left out."""

from egad.tables.columns import (
    CELL_CONFIDENCE,
    CELLS,
    COMPLEXITY,
    DIVERSITY,
    FLOAT,
    GRASPABILITY,
    GRASPABILITY_STD,
    ID,
    INERTIA_COLUMNS,
    INT,
    LABEL,
    RAW_COMPLEXITY,
    STRING,
    Result,
    binary,
    boolean,
    integer,
    real,
    schema,
    text,
    values,
    vector,
)

_SHELL = real(
    "shell_thickness",
    "wall thickness that an open surface was given; 0 if the surface was closed",
    "m",
)
_DROPPED = [
    integer("dropped_bodies", "number of bodies, closed or open, that repair left out"),
    real(
        "dropped_volume",
        "volume of the bodies left out / volume of all bodies, with holes closed; 0 if those left "
        "out have no volume",
    ),
]
_REPAIR = [
    boolean("repaired", "whether repair changed the mesh beyond merging vertices"),
    _SHELL,
    *_DROPPED,
]
_GRAPH = binary("graph", "packed Reeb graph of the object")
_GRASPS = integer("grasps", "number of grasps that the graspability was computed from")
SOLIDS = schema(
    ID,
    COMPLEXITY,
    RAW_COMPLEXITY,
    GRASPABILITY,
    GRASPABILITY_STD,
    CELL_CONFIDENCE,
    _GRASPS,
    real("archive_graspability", "graspability measured during evolution, for selection"),
    real("volume", "volume of the solid", "m3"),
    real("area", "surface area", "m2"),
    boolean("watertight", "whether every edge has exactly two faces"),
    *_REPAIR,
    *vector("extents", "sides of the axis-aligned box", "m"),
    *vector("com", "center of mass", "m"),
    real("mass", "mass at the configured density", "kg"),
    *INERTIA_COLUMNS,
    values("vertices", "vertex coordinates, flat", "m", of=FLOAT),
    values("faces", "vertex indices of the triangles, flat", of=INT),
    _GRAPH,
)
GRAPHS = schema(ID, _GRAPH)

_INTERNAL = {"vertices", "faces", "graph"}
OBJECTS = schema(
    ID,
    LABEL,
    *[field for field in SOLIDS if field.name not in _INTERNAL | {"id"}],
    *CELLS,
    DIVERSITY,
)

GRASPABILITIES = schema(LABEL, GRASPABILITY, GRASPABILITY_STD, _GRASPS)

REJECTED = schema(
    text("id", "object or file that was rejected"),
    text("stage", "stage that rejected it"),
    text("reason", "why it was rejected"),
)

_REASON = text("reason", "why it could not be measured; empty if it was")
MEASURED = schema(
    text("name", "name of the mesh file"),
    COMPLEXITY,
    RAW_COMPLEXITY,
    GRASPABILITY,
    GRASPABILITY_STD,
    *CELLS,
    CELL_CONFIDENCE,
    _GRASPS,
    real("longest_side", "longest side of the axis-aligned box", "m"),
    text("rule", "scale rule; the cells of the map use `exact`"),
    real("opening", "widest opening of the gripper", "m"),
    real("factor", "size at which grasps were sampled / size of the mesh"),
    *vector("grasped", "side of the box at that size, ascending", "m", "123"),
    *_REPAIR,
    _REASON,
)

LOCATED = schema(
    text("name", "name of the mesh file"),
    COMPLEXITY,
    GRASPABILITY,
    GRASPABILITY_STD,
    *CELLS,
    CELL_CONFIDENCE,
    real("complexity_percentile", "percentage of the objects that are simpler", "%"),
    real("difficulty_percentile", "percentage of the objects that are easier", "%"),
    real("diversity", "mean distance to the nearest objects"),
    values("nearest", "nearest objects, nearest first", of=STRING),
    values("distances", "distances to the nearest objects", of=FLOAT),
    _SHELL,
    *_DROPPED,
    _REASON,
)

COMPARISON = schema(
    text("dataset", "name of the dataset"),
    integer("objects", "number of objects"),
    real("coverage", "archive coverage: fraction of the slots of all cells that are filled"),
    real(
        "attainable_coverage",
        "fraction of the slots that are filled, without the easiest rows, where no object is "
        "expected (studies/search/README.md)",
    ),
    real("filled_cells", "fraction of the cells that hold at least one object"),
    real("diversity_min", "diversity of the least diverse object"),
    real("diversity_max", "diversity of the most diverse object"),
    real("diversity_mean", "mean diversity"),
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
