"""Files of the gallery: scripts that carry its data, and sheets of many small pictures.

Browsers do not let a page read files from a local folder, but they run scripts from it. So all data
files are scripts that call `egadData(NAME, DATA)`, which `gallery.js` defines.
"""

import io
import json
from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import quote

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from PIL import Image

from egad._util.arrays import RgbImage

FOLDER = "gallery"
INDEX = "index"
SHEETS, PAGES, ANCESTORS = "sheets", "objects", "ancestors"


def data_script(name: str, data: Mapping[str, Any]) -> str:
    """A script that hands JSON data to the page, which requests it by its path without ending."""
    return f"egadData({_json(name)},{_json(data)});\n"


def file_link(*parts: str) -> str:
    """A relative link to a file, from the parts of its path."""
    return "/".join(quote(part, safe="") for part in parts)


def _json(value: object) -> str:
    """Compact JSON in ASCII, which is JavaScript too."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False)


def rounded(value: float | None) -> float | None:
    """A number with six significant digits; None if it is unknown."""
    return None if value is None or value != value else float(f"{value:.6g}")


TILE = 64  # pixels along each side of a picture
COLUMNS = 16  # pictures in a row of a sheet of ancestors
PER_SHEET = COLUMNS**2
QUALITY = 75  # of WebP; at 64 pixels, no difference from a lossless file is visible

Place = tuple[int, int]


def cell_ranks(objects: pd.DataFrame) -> NDArray[np.int64]:
    """The rank of each object in its cell, (n,): 0 is the most diverse. Sheet k has rank k."""
    ordered = objects.sort_values(["diversity", "label"], ascending=[False, True])
    ranks = ordered.groupby(["complexity_cell", "difficulty_cell"]).cumcount()
    return np.asarray(ranks.loc[objects.index], dtype=np.int64)


def sheet(pictures: Mapping[Place, RgbImage], columns: int, rows: int) -> bytes:
    """A WebP file of (TILE, TILE, 4) by column and row from the top; same pictures, same bytes."""
    canvas = np.zeros((rows * TILE, columns * TILE, 4), np.uint8)
    for (column, row), picture in pictures.items():
        top, left = row * TILE, column * TILE
        canvas[top : top + TILE, left : left + TILE] = picture
    buffer = io.BytesIO()
    Image.fromarray(canvas, "RGBA").save(buffer, "webp", quality=QUALITY, method=4)
    return buffer.getvalue()


def ancestor_sheets(pictures: Mapping[int, RgbImage], count: int) -> Iterator[bytes]:
    """The sheets of ancestors by number, left to right, then down; some have no picture."""
    for start in range(0, count, PER_SHEET):
        numbers = [number for number in range(start, start + PER_SHEET) if number in pictures]
        places = {divmod(number - start, COLUMNS)[::-1]: pictures[number] for number in numbers}
        yield sheet(places, COLUMNS, PER_SHEET // COLUMNS)
