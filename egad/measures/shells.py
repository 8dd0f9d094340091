"""The outer surface of a body."""

import numba
import numpy as np
from numpy.typing import NDArray

from egad.errors import RejectedError
from egad.measures.ranges import labels, unite

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

_SPECK = 1e-6  # of the volume of a body: what is smaller inside it is a cavity, however wound


def outer_shell(vertices: Floats, faces: Ints) -> Ints:
    """The faces of a body without the walls of its cavities, which nothing can see or touch.

    A cavity is a shell within the box of the largest one that is wound the other way.

    Args:
        vertices: (n, 3).
        faces: (f, 3).

    Raises:
        RejectedError: The surface is in several pieces, and not all but one are cavities.
    """
    shells = _shells(faces, len(vertices))
    count = shells.max() + 1
    if count == 1:
        return faces
    corners = vertices[faces]
    sizes = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    largest = np.bincount(shells, sizes).argmax()
    own = shells == largest
    low, high = corners[own].min(axis=(0, 1)), corners[own].max(axis=(0, 1))
    volumes = np.bincount(shells, np.linalg.det(corners - (low + high) / 2))
    hollow = volumes * volumes[largest] <= _SPECK * volumes[largest] ** 2
    inside = ((corners >= low) & (corners <= high)).all(axis=(1, 2))
    if not (own | (hollow[shells] & inside)).all():
        raise RejectedError("the mesh is not one connected piece")
    outer: Ints = faces[own]
    return outer


@numba.njit(cache=True)
def _shells(faces: Ints, count: int) -> Ints:
    """Number of the connected piece that each face belongs to."""
    roots = np.arange(count).astype(np.int32)
    for a, b, c in faces:
        unite(roots, a, b)
        unite(roots, a, c)
    met, _ = labels(roots)
    numbers, result, used = np.full(count, -1, np.int32), np.empty(len(faces), np.int32), 0
    for face, (a, _, _) in enumerate(faces):
        if numbers[met[a]] < 0:
            numbers[met[a]] = used
            used += 1
        result[face] = numbers[met[a]]
    return result
