"""Checks of meshes that users pass: typed errors before anything is computed from them."""

import contextlib
import inspect
import traceback
import warnings
from collections.abc import Mapping
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from egad._util.arrays import Flags, Floats, Ints
from egad.errors import RejectedError, UserError

PACKAGE = Path(__file__).parents[1]
# Usual longest sides of graspable objects, metres. A 60 mm object falls outside this range if m, mm
# and inch are confused, or m and cm; confusing mm or inch with cm still gives usual sizes.
USUAL_SIDES = (0.005, 1.0)
ROUNDING = 1e-12  # of the cube of the longest side: a smaller volume counts as none

OPEN = "open or inconsistently wound surface: `egad.repair` may close it"


class UnitsWarning(UserWarning):
    """The size of a mesh suggests that its coordinates are not in metres."""


class ScaleWarning(UserWarning):
    """A mesh is measured larger than it is."""


class DroppedBodiesWarning(UserWarning):
    """Only the largest body of a mesh is used."""


def warn_user(text: str, category: type[UserWarning]) -> None:
    """Issue a warning that names the line that called egad."""
    warnings.warn(text, category, stacklevel=_calls_within_egad())


def check_mesh(mesh: Any) -> None:  # noqa: ANN401 (whatever users pass)
    """Raise `UserError` if it is no mesh, `RejectedError` if it has no valid faces and vertices."""
    if not isinstance(mesh, trimesh.Trimesh):
        advice = ""
        if isinstance(mesh, trimesh.Scene):
            advice = "; `scene.to_mesh()` makes one mesh of a scene"
        elif isinstance(mesh, str | Path):
            advice = "; `egad.read_mesh(path, units='mm')` reads one from a file"
        raise UserError(f"a mesh must be a trimesh.Trimesh, got {type(mesh).__name__}{advice}")
    faces = np.asarray(mesh.faces)
    if len(faces) == 0:
        raise RejectedError("no faces")
    if not np.isfinite(mesh.vertices).all():
        raise RejectedError("coordinates that are not finite")
    if faces.min() < 0 or faces.max() >= len(mesh.vertices):
        raise RejectedError("faces refer to vertices that do not exist")


def check_surface(mesh: trimesh.Trimesh) -> None:
    """Raise the errors of `check_mesh`, or `RejectedError` if a mesh has no area."""
    check_mesh(mesh)
    if not mesh.area > 0:
        raise RejectedError("no area")


def check_solid(mesh: trimesh.Trimesh) -> None:
    """Raise those of `check_surface`, or `RejectedError` for an open, inverted or empty surface."""
    check_surface(mesh)
    if not is_closed(mesh):
        raise RejectedError(OPEN)
    faces, size = np.asarray(mesh.faces), float(mesh.extents.max())
    volume = cone_volumes(np.asarray(mesh.vertices) / size, faces).sum()
    if abs(volume) < ROUNDING:
        raise RejectedError("no volume")
    if volume < 0:
        raise RejectedError("inside out: `egad.repair` turns the faces outwards")


def is_closed(mesh: trimesh.Trimesh) -> bool:
    """Whether every edge has as many faces in one direction as in the other."""
    faces, count = np.asarray(mesh.faces, np.int64), len(mesh.vertices)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    return bool(np.array_equal(np.sort(start * count + end), np.sort(end * count + start)))


def cone_volumes(vertices: Floats, faces: Ints) -> Floats:
    """Signed volume between each face and the middle of the bounding box, (m,)."""
    corners = vertices[faces]
    middle = (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1))) / 2
    a, b, c = np.moveaxis(corners - middle, 1, 0)
    return np.asarray(np.einsum("ij,ij->i", a, np.cross(b, c)) / 6)


def check_units(mesh: trimesh.Trimesh, what: str = "the mesh", unit: str = "metres") -> None:
    """Warn, naming the line that called egad, if the longest side is not between 5 mm and 1 m."""
    check_mesh(mesh)
    longest = float(mesh.extents.max())
    if not has_usual_size(longest):
        low, high = USUAL_SIDES
        warn_user(
            f"the longest side of {what} is {longest:.3g} m, which is not between {low:g} m and "
            f"{high:g} m: are its coordinates really in {unit}?",
            UnitsWarning,
        )


def _calls_within_egad() -> int:
    """Calls from the user's line down to this one; those of `contextlib` are of decorators."""
    calls = traceback.walk_stack(inspect.currentframe())
    files = (Path(frame.f_code.co_filename) for frame, _ in calls)
    ours = (PACKAGE in file.parents or file == Path(contextlib.__file__) for file in files)
    return len(list(takewhile(bool, ours)))


def units_doubt(longest_sides: Mapping[str, float], unit: str | None) -> str:
    """A sentence about unusual longest sides, metres by name, NaN if unread; empty without any."""
    known = {name: side for name, side in longest_sides.items() if np.isfinite(side)}
    odd = {name: side for name, side in known.items() if not has_usual_size(side)}
    if not odd:
        return ""
    name, side = next(iter(odd.items()))
    low, high = USUAL_SIDES
    return (
        f"{len(odd)} of {len(longest_sides)} meshes are smaller than {low:g} m or larger than "
        f"{high:g} m, for example {name} ({side:.3g} m): is their unit {unit or 'right'}?"
    )


def has_usual_size(longest_sides: ArrayLike) -> Flags:
    """Whether meshes have the size of graspable objects, given longest sides in metres, (n,)."""
    low, high = USUAL_SIDES
    sides = np.asarray(longest_sides, dtype=np.float64)
    return np.asarray((sides >= low) & (sides <= high))
