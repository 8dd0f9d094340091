"""Depths and masks as PNG files, as they are in the rows of rendered images."""

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from egad.errors import TableError

UNIT = 1e-4  # metres; of the depths in the files
LEVEL = 6  # of compression


def coded(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Depths in units of 0.1 mm; 0 for what is missing or deeper than 6.5 m."""
    steps = np.round(depth.astype(np.float64) / UNIT)
    known = np.isfinite(steps) & (steps < 2**16)
    return np.where(known, steps, 0).astype(np.uint16)


def png(pixels: NDArray[np.uint16] | NDArray[np.uint8]) -> bytes:
    """A PNG file of one channel."""
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "png", compress_level=LEVEL)
    return buffer.getvalue()


def depth_of(row: Mapping[str, Any]) -> NDArray[np.float32]:
    """The depths of a row, metres, not a number where they are missing; errors as `pixels`."""
    steps = pixels(row, "depth", "I")
    return np.where(steps > 0, steps * UNIT, np.nan).astype(np.float32)


def pixels(row: Mapping[str, Any], name: str, mode: str) -> NDArray[np.integer]:
    """The pixels of a PNG file of a row, (height, width) as the row says.

    Args:
        row: Has `height`, `width` and the file.
        name: Of its column.
        mode: How Pillow calls such pixels, or how that begins.

    Raises:
        TableError: The file is damaged, or of another size or kind.
    """
    try:
        with Image.open(io.BytesIO(row[name]), formats=["PNG"]) as image:
            if image.size != (row["width"], row["height"]) or not image.mode.startswith(mode):
                raise ValueError("it is not of the size and kind that is said")
            return np.asarray(image)
    except (ValueError, OSError, SyntaxError, TypeError, Image.DecompressionBombError) as error:
        raise TableError(f"its {name} cannot be read: {error}") from error
