"""Files of the gallery, and the scripts that carry its data.

Browsers do not let a page read files from a local folder, but they run scripts from it. So all data
files are scripts that call `egadData(NAME, DATA)`, which `gallery.js` defines.
"""

import json
from collections.abc import Mapping
from typing import Any
from urllib.parse import quote

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
