"""Building blocks of the schemas: types, and the columns that several tables share."""

import re
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import pandas as pd
import pyarrow as pa

from egad._util.arrays import Floats
from egad.errors import TableError

STRING, INT, FLOAT, BOOL, BINARY = (
    pa.string(),
    pa.int32(),
    pa.float64(),
    pa.bool_(),
    pa.large_binary(),
)


class Result(NamedTuple):
    """A file or folder that a run writes."""

    path: str  # in `results/`; D stands for a dataset, G for a gripper, P for a grasp detector
    meaning: str
    columns: pa.Schema | None = None


def column(name: str, meaning: str, unit: str = "", *, kind: pa.DataType) -> pa.Field:
    """A column with its meaning, and its unit if it has one."""
    return pa.field(name, kind, metadata={"meaning": meaning, "unit": unit})


text, integer, real = (partial(column, kind=each) for each in (STRING, INT, FLOAT))
boolean, binary = (partial(column, kind=each) for each in (BOOL, BINARY))


def values(name: str, meaning: str, unit: str = "", *, of: pa.DataType) -> pa.Field:
    """A column of lists."""
    return column(name, meaning, unit, kind=pa.list_(of))


def schema(*fields: pa.Field) -> pa.Schema:
    """The schema of some columns."""
    return pa.schema(fields)


def optional(field: pa.Field) -> pa.Field:
    """A column that a file may lack: it is then read as NaN."""
    return field.with_metadata({**field.metadata, b"optional": b"true"})


def meaning_of(field: pa.Field) -> tuple[str, str]:
    """The meaning and the unit of a column that `column` made."""
    return field.metadata[b"meaning"].decode(), field.metadata[b"unit"].decode()


def vector(
    name: str, meaning: str, unit: str = "", parts: str | tuple[str, ...] = "xyz"
) -> list[pa.Field]:
    """A column for each part of a vector: NAME_PART."""
    return [real(f"{name}_{part}", f"{meaning}, {part}", unit) for part in parts]


def vector_names(name: str) -> list[str]:
    """The columns of a vector in space."""
    return [f"{name}_{part}" for part in "xyz"]


INERTIA = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


def inertia_columns(tensor: Floats) -> dict[str, float]:
    """The columns of a symmetric tensor (3, 3) by name: inertia_xx to inertia_yz."""
    return {f"inertia_{name}": float(tensor[place]) for name, place in INERTIA.items()}


INERTIA_COLUMNS = vector(
    "inertia", "moment of inertia about the center of mass", "kg m2", tuple(INERTIA)
)

POSE_PARTS = ("x", "y", "z", "qx", "qy", "qz", "qw")
INITIAL = tuple(f"initial_{part}" for part in POSE_PARTS)


def pose(name: str, meaning: str) -> list[pa.Field]:
    """Columns of a position in metres and a quaternion: NAME_x to NAME_qw."""
    position = vector(name, meaning, "m")
    return [*position, *vector(name, f"{meaning}, quaternion", parts=POSE_PARTS[3:])]


ID = text("id", "name of the object in its dataset, never reused for another shape")
LABEL = text("label", "readable name, used in file names: difficulty letter, complexity, index")
COMPLEXITY = real(
    "complexity",
    "entropy of the angular deficits; for meshes that were not evolved, on the closest voxels",
    "bit",
)
RAW_COMPLEXITY = real(
    "raw_complexity", "entropy of the angular deficits at the vertices of the mesh as it is", "bit"
)
GRASPABILITY = real("graspability", "percentile of grasp quality, high for easy objects")
GRASPABILITY_STD = real("graspability_std", "standard error of the graspability")
CELL_CONFIDENCE = real(
    "cell_confidence", "probability that the exact graspability lies in the same row"
)
CELLS = [
    integer("complexity_cell", "cell along complexity, 0 = simplest"),
    integer("difficulty_cell", "cell along difficulty, 0 = easiest"),
]
QUALITY = real(
    "quality",
    "Ferrari-Canny quality; for a cup, the fraction of perturbed copies that seal and hold; for a "
    "sampler of your own, the quality that it gives",
)
ROBUST_QUALITY = real(
    "robust_quality",
    "mean quality over perturbed copies of the grasp; for cups and samplers of your own, the same "
    "as the quality",
)
ROBUST_SUCCESS_RATE = real(
    "robust_success_rate", "robust success rate: fraction of perturbed copies with positive quality"
)
DIVERSITY = real("diversity", "mean distance to the nearest objects of the dataset")

LABELS = ("label", "object_label")
_UNSAFE = re.compile(r"[/\\\x00]|^\.{1,2}$")


def check_names(frame: pd.DataFrame, path: Path, columns: Sequence[str] = LABELS) -> None:
    """Raise a `TableError` that names an object whose name cannot be that of a file anywhere."""
    for column in (name for name in columns if name in frame):
        for name in frame[column].unique():
            if isinstance(name, str) and _UNSAFE.search(name):
                raise TableError(f"{path}: the {column} {name!r} is not a valid file name")
