"""The Arrow schema of every Parquet artefact: columns, units and meanings.

`read` and `write` are the only way in and out. A table is written under a temporary name and then
renamed, so a file that exists is complete.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from egad.files import replacing

_STRING, _INT, _FLOAT, _BOOL, _BINARY = (
    pa.string(),
    pa.int32(),
    pa.float64(),
    pa.bool_(),
    pa.large_binary(),
)

_NOTES = "egad"


class TableError(ValueError):
    """A Parquet file is missing, damaged, or does not have the columns of its schema."""


def _column(name: str, kind: pa.DataType, meaning: str, unit: str = "") -> pa.Field:
    return pa.field(name, kind, metadata={"meaning": meaning, "unit": unit})


def _vector(
    name: str, meaning: str, unit: str = "", parts: str | tuple[str, ...] = "xyz"
) -> list[pa.Field]:
    return [_column(f"{name}_{part}", _FLOAT, f"{meaning}, {part}", unit) for part in parts]


_ID = _column(
    "id", _STRING, "name of the object within its dataset, never reused for another shape"
)
_LABEL = _column(
    "label", _STRING, "name for people and files: difficulty letter, complexity, index"
)
_COMPLEXITY = _column("complexity", _FLOAT, "entropy of the angular deficits", "bit")
_DIFFICULTY = _column("difficulty", _FLOAT, "percentile of grasp quality: high is easy")
_CELLS = [
    _column("complexity_cell", _INT, "cell along complexity, 0 = simplest"),
    _column("difficulty_cell", _INT, "cell along difficulty, 0 = easiest"),
]
_DIVERSITY = _column("diversity", _FLOAT, "mean distance to the nearest objects of the dataset")

GENOME = pa.schema(
    [
        _column("node_keys", pa.list_(pa.int64()), "nodes; 0 is the output, -1..-7 are inputs"),
        _column("node_biases", pa.list_(_FLOAT), "bias of each node"),
        _column("node_activations", pa.list_(_STRING), "activation function of each node"),
        _column("connection_sources", pa.list_(pa.int64()), "node that each connection leaves"),
        _column("connection_targets", pa.list_(pa.int64()), "node that each connection enters"),
        _column("connection_weights", pa.list_(_FLOAT), "weight of each connection"),
        _column("connection_enabled", pa.list_(_BOOL), "whether each connection is in use"),
    ]
)

ARCHIVE = pa.schema(
    [
        _ID,
        *GENOME,
        _column("voxels", _BINARY, "solid voxels, x slowest and z fastest, one bit each"),
        _COMPLEXITY,
        _DIFFICULTY,
        _DIVERSITY,
        *_CELLS,
        _column("slot", _INT, "index within the cell, 0 = most diverse"),
        _column("parents", pa.list_(_STRING), "ids of the parents; none for a random genome"),
        _column("epoch", _INT, "epoch that the object was born in"),
    ]
)

EPOCH = pa.schema([*ARCHIVE, _column("graph", _BINARY, "packed Reeb graph of the object")])

HISTORY = pa.schema(
    [
        _column("epoch", _INT, "number of the epoch"),
        _column("island", _INT, "number of the island"),
        _column("step", _INT, "number of the step in its epoch"),
        _column("offspring", _INT, "offspring of this step"),
        _column("evaluated", _INT, "of these, measured and offered to the archive"),
        _column("empty", _INT, "of these, without any solid voxel"),
        _column("known", _INT, "of these, with the voxels of another"),
        _column("elites", _INT, "objects in the archive of the island after the step"),
        _column("coverage", _FLOAT, "part of the places that they fill"),
        _column("filled_cells", _FLOAT, "part of the cells that hold at least one"),
        _column("qd_score", _FLOAT, "sum of their diversities; of every tenth step"),
        _column("cells", _BINARY, "how many each cell holds, one byte each, by rows of difficulty"),
    ]
)

SOLIDS = pa.schema(
    [
        _ID,
        _COMPLEXITY,
        _DIFFICULTY,
        _column("grasps", _INT, "grasps that the difficulty was computed from"),
        _column("archive_difficulty", _FLOAT, "difficulty that evolution selected it by"),
        _column("volume", _FLOAT, "volume", "m3"),
        _column("area", _FLOAT, "surface area", "m2"),
        _column("watertight", _BOOL, "whether every edge has exactly two faces"),
        _column("repaired", _BOOL, "whether repair changed the mesh beyond merging vertices"),
        *_vector("extents", "sides of the axis-aligned box", "m"),
        *_vector("com", "centre of mass", "m"),
        _column("mass", _FLOAT, "mass at the configured density", "kg"),
        *_vector(
            "inertia",
            "moment of inertia about the centre of mass",
            "kg m2",
            ("xx", "yy", "zz", "xy", "xz", "yz"),
        ),
        _column("vertices", pa.list_(_FLOAT), "vertex coordinates, flat", "m"),
        _column("faces", pa.list_(_INT), "vertex indices of the triangles, flat"),
        _column("graph", _BINARY, "packed Reeb graph of the object"),
    ]
)

_REASON = _column("reason", _STRING, "why it could not be measured; empty if it was")
MEASURED = pa.schema(
    [
        _column("name", _STRING, "name of the mesh file"),
        _COMPLEXITY,
        _DIFFICULTY,
        *_CELLS,
        _column("grasps", _INT, "grasps that the difficulty was computed from"),
        _column("longest_side", _FLOAT, "longest side of the axis-aligned box", "m"),
        _column("repaired", _BOOL, "whether repair changed the mesh beyond merging vertices"),
        _REASON,
    ]
)

LOCATED = pa.schema(
    [
        _column("name", _STRING, "name of the mesh file"),
        _COMPLEXITY,
        _DIFFICULTY,
        *_CELLS,
        _column("complexity_percentile", _FLOAT, "part of the objects that are simpler", "%"),
        _column("difficulty_percentile", _FLOAT, "part of the objects that are easier", "%"),
        _column("diversity", _FLOAT, "mean distance to the nearest objects"),
        _column("nearest", pa.list_(_STRING), "the nearest objects, the nearest first"),
        _column("distances", pa.list_(_FLOAT), "distances to them"),
        _REASON,
    ]
)

_INTERNAL = {"vertices", "faces", "graph"}
OBJECTS = pa.schema(
    [
        _ID,
        _LABEL,
        *[field for field in SOLIDS if field.name not in _INTERNAL | {"id"}],
        *_CELLS,
        _DIVERSITY,
    ]
)

REJECTED = pa.schema(
    [
        _column("id", _STRING, "object or file that was left out"),
        _column("stage", _STRING, "stage that left it out"),
        _column("reason", _STRING, "why"),
    ]
)

GRASPS = pa.schema(
    [
        _ID,
        _LABEL,
        _column("grasp", _INT, "number of the grasp on its object"),
        *_vector("center", "midpoint of the contacts", "m"),
        *_vector("axis", "unit vector from the first contact to the second"),
        *_vector("approach", "unit vector along which the hand moves towards the object"),
        _column("width", _FLOAT, "distance of the contacts", "m"),
        *_vector("contact0", "first contact", "m"),
        *_vector("contact1", "second contact", "m"),
        *_vector("normal0", "outward unit normal at the first contact"),
        *_vector("normal1", "outward unit normal at the second contact"),
        _column("quality", _FLOAT, "Ferrari-Canny quality"),
        _column("robust_quality", _FLOAT, "mean quality over disturbed copies"),
        _column("robust_quality_std", _FLOAT, "standard deviation over disturbed copies"),
        _column("held", _FLOAT, "fraction of the disturbed copies with positive quality"),
        _column("collision_free", _BOOL, "whether the hand fits at the grasp along the approach"),
    ]
)

SCALES = pa.schema(
    [
        _LABEL,
        _column("rule", _STRING, "scale rule"),
        _column("opening", _FLOAT, "opening of the gripper", "m"),
        _column("factor", _FLOAT, "scaled size / size before"),
        *_vector("before", "sides of the minimum-volume box before, ascending", "m", "123"),
        *_vector("after", "sides of the minimum-volume box after, ascending", "m", "123"),
    ]
)

EVAL49 = pa.schema(
    [
        _column("label", _STRING, "name in the evaluation set, A0 = easiest and simplest"),
        _ID,
        _column("object_label", _STRING, "label of the object in its dataset"),
        _column("row", _INT, "row of the coarse grid, 0 = easiest"),
        _column("column", _INT, "column of the coarse grid, 0 = simplest"),
        _COMPLEXITY,
        _DIFFICULTY,
        *_CELLS,
        _column("nearest", _FLOAT, "distance to the nearest other object of the set"),
    ]
)

MANIFEST = pa.schema(
    [
        _column("label", _STRING, "name in the evaluation set"),
        _ID,
        _column("file", _STRING, "STL file, coordinates in millimetres"),
        _column("plate", _INT, "number of the 3MF plate; null if it does not fit the bed"),
        *_vector("place", "lowest corner on the plate", "mm", "xy"),
        *_vector("extents", "sides of the axis-aligned box as printed", "mm"),
        _column("volume", _FLOAT, "volume of the solid", "mm3"),
        _column("factor", _FLOAT, "scaled size / size in meshes/"),
        _column("note", _STRING, "what to know before printing; empty if nothing"),
    ]
)

TRIALS = pa.schema(
    [
        _column("label", _STRING, "name in the evaluation set"),
        _ID,
        _column("attempt", _INT, "number of the attempt"),
        _column("seed", pa.string(), "seed of the attempt (hexadecimal)"),
        _column("success", _BOOL, "whether the object was still held at the end"),
        _column(
            "outcome",
            _STRING,
            "success, no_grasp, collided, missed, slipped, dropped or failed",
        ),
        *_vector("grasp", "grasp centre chosen by the detector, world frame", "m"),
        _column("angle", _FLOAT, "angle of the closing axis about the vertical", "rad"),
        _column("width", _FLOAT, "opening that the detector asked for", "m"),
        _column("quality", _FLOAT, "quality that the detector gave"),
        _column("lifted", _FLOAT, "height gained by the object at the end", "m"),
        _column("parts", _INT, "convex parts of the simulated object"),
        _column("volume_error", _FLOAT, "volume of the parts / volume of the object - 1"),
    ]
)

COMPARISON = pa.schema(
    [
        _column("dataset", _STRING, "name of the dataset"),
        _column("objects", _INT, "objects in it"),
        _column("coverage", _FLOAT, "part of the places filled, as many a cell as it keeps elites"),
        _column("filled_cells", _FLOAT, "part of the cells that hold at least one object"),
        _column("diversity_min", _FLOAT, "diversity of the least diverse object"),
        _column("diversity_max", _FLOAT, "diversity of the most diverse object"),
        _column("diversity_mean", _FLOAT, "mean diversity"),
    ]
)


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a table, each as a dictionary by column."""
    return [{str(name): value for name, value in row.items()} for row in frame.to_dict("records")]


def empty(schema: pa.Schema) -> pd.DataFrame:
    """A table with the columns of a schema and no rows."""
    frame: pd.DataFrame = schema.empty_table().to_pandas()
    return frame


def write(
    frame: pd.DataFrame, schema: pa.Schema, path: Path, notes: Mapping[str, Any] | None = None
) -> None:
    """Write a table atomically: exactly the columns of its schema, in that order.

    Args:
        frame: The rows.
        schema: The columns.
        path: The file.
        notes: Kept in the file beside the rows; see `notes`.
    """
    columns = frame[schema.names] if len(frame) else empty(schema)
    table = pa.Table.from_pandas(columns, schema=schema, preserve_index=False)
    kept = {_NOTES: json.dumps(notes, sort_keys=True)} if notes else None
    table = table.replace_schema_metadata(kept)
    with replacing(path) as temporary, temporary.open("wb") as file:
        pq.write_table(table, file, compression="zstd")


def columns(path: Path) -> list[str]:
    """Names of the columns of a table.

    Raises:
        TableError: The file is missing, is not Parquet, or is cut short.
    """
    return list(_schema(path).names)


def _schema(path: Path) -> pa.Schema:
    try:
        return pq.read_schema(path)
    except (OSError, pa.ArrowException) as error:
        raise TableError(f"{path}: not a readable Parquet file ({error})") from error


def notes(path: Path) -> dict[str, Any]:
    """What was kept in a file beside its rows; nothing if it has no such notes.

    Raises:
        TableError: The file is missing, is not Parquet, or is cut short.
    """
    kept = (_schema(path).metadata or {}).get(_NOTES.encode())
    found: dict[str, Any] = json.loads(kept) if kept else {}
    return found


def read(path: Path, schema: pa.Schema) -> pd.DataFrame:
    """Read a table and check that it has the columns of its schema.

    Raises:
        TableError: The file is missing, is not Parquet, is cut short, or has other columns.
    """
    try:
        table = pq.read_table(path)
    except (OSError, pa.ArrowException) as error:
        raise TableError(f"{path}: not a readable Parquet file ({error})") from error
    missing = [name for name in schema.names if name not in table.column_names]
    if missing:
        raise TableError(f"{path}: columns are missing: {', '.join(missing)}")
    frame: pd.DataFrame = table.select(schema.names).to_pandas()
    return frame
