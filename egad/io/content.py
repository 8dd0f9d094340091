"""What a mesh file holds."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Content(NamedTuple):
    """A surface of triangles, in the unit of the file and in the axes of its format.

    Attributes:
        vertices: (n, 3).
        faces: (m, 3) vertex indices.
        unit: The unit that the file states: one of `egad.io.units.LENGTHS`; None if it states none.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    unit: str | None = None
