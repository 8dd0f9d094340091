"""Array types by the type of their elements."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Ints = NDArray[np.int64]
Ints32 = NDArray[np.int32]
Flags = NDArray[np.bool_]
RgbImage = NDArray[np.uint8]


def dot_products(first: Floats, second: Floats) -> Floats:
    """Dot products (n, m) of vectors (n, 3) and (m, 3), with the same bits on every processor.

    Matrix products depend on the kernels that BLAS has for a processor.
    """
    (x, y, z), (a, b, c) = first.T[:, :, None], second.T[:, None]
    products: Floats = x * a + y * b + z * c
    return products
