"""Display of results: pictures that can be saved, and HTML for notebooks.

The drawing code is in `egad.report`. It is imported by name when it is needed: it does not affect
results, so changes to it must not re-run jobs.
"""

import importlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from egad._util.files import as_path, write_text
from egad.errors import UserError

if TYPE_CHECKING:
    import pandas as pd
    import trimesh


@dataclass(frozen=True, repr=False)
class Picture:
    """A drawing that notebooks show and that can be saved; `plot()` of a result returns it.

    Attributes:
        svg: The text of the drawing, which needs no other file.
    """

    svg: str

    def __repr__(self) -> str:
        return "Picture: save('picture.svg') writes it; a notebook shows it"

    def save(self, path: str | Path) -> None:
        """Write the drawing, atomically, to a file that ends in `.svg`; otherwise `UserError`."""
        file = as_path("path", path)
        if file.suffix.lower() != ".svg":
            raise UserError(f"path is {str(file)!r}; allowed: a file that ends in .svg")
        write_text(file, self.svg)

    def _repr_svg_(self) -> str:
        return self.svg


def draw(module: str, function: str, *values: object) -> Picture:
    """Let a function of a module in `egad.report`, which returns SVG text, draw a picture."""
    return Picture(_call(module, function, *values))


def facts_html(
    title: str, facts: Mapping[str, object], mesh: "trimesh.Trimesh | None" = None
) -> str:
    """HTML of a result: what it is, its facts as a table, and a thumbnail of its mesh, if any."""
    return _call("notebook", "facts_html", title, facts, mesh)


def thumbnail(mesh: "trimesh.Trimesh", size: int) -> bytes:
    """A PNG file of a mesh, `size` pixels wide, from in front and above, on no background."""
    pictures = importlib.import_module("egad.report.pictures")
    content: bytes = pictures.png_bytes(pictures.render(mesh, size))
    return content


def table_html(title: str, table: "pd.DataFrame") -> str:
    """HTML of a table; only the first and last rows of a long one."""
    return _call("notebook", "table_html", title, table)


def _call(module: str, function: str, *values: object) -> str:
    text: str = getattr(importlib.import_module(f"egad.report.{module}"), function)(*values)
    return text
