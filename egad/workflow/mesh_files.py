"""Mesh files of users: the result of each, or why there is none, and whether its unit is right."""

import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np
import trimesh

from egad.errors import RejectedError
from egad.geometry import units_doubt
from egad.io import read_mesh

T = TypeVar("T")
log = logging.getLogger(__name__)


def use_mesh(
    path: Path, units: str | None, use: Callable[[trimesh.Trimesh], T]
) -> tuple[T | str, float]:
    """What is made from a mesh file, or the reason why nothing is; and its longest side, metres.

    The side is NaN if the file cannot be read. The unit is as stated in the file if None; `use` may
    raise `RejectedError`.
    """
    longest = np.nan
    try:
        mesh = read_mesh(path, units)
        longest = float(mesh.extents.max())
        return use(mesh), longest
    except RejectedError as reason:
        return str(reason), longest


def warn_of_units(sides: Mapping[str, float], units: str | None) -> None:
    """Warn if the size of meshes, longest sides in metres, suggests that their unit is wrong."""
    if doubt := units_doubt(sides, units):
        log.warning("%s", doubt)
