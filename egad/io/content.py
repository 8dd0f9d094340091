"""What a mesh file holds."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Content(NamedTuple):
    """A surface of triangles, in the unit of the file and in the axes of its format."""

    vertices: NDArray[np.float64]  # (n, 3)
    faces: NDArray[np.int64]  # (m, 3) vertex indices
    unit: str | None = None  # one of `egad.io.units.LENGTHS`, if the file states it
