"""All objects of an evaluation set on one page, to tell prints apart."""

import io
from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
import trimesh
from matplotlib.figure import Figure

from egad.report.render import render
from egad.report.style import INK, SOFT, STYLE

PAGE = (8.27, 11.69)  # A4, inches
PIXELS = 220


def contact_sheet(
    title: str,
    rows: int,
    columns: int,
    meshes: Mapping[tuple[int, int], trimesh.Trimesh],
    captions: Mapping[tuple[int, int], tuple[str, str]],
) -> bytes:
    """A PDF page with a picture, name and size for each object, the same for the same objects.

    Args:
        title: Above the pictures.
        rows: Of the grid.
        columns: Of the grid.
        meshes: By row and column.
        captions: Name and size, by row and column; a place without a mesh shows just these.
    """
    with matplotlib.rc_context({**STYLE, "pdf.fonttype": 42}):
        figure = Figure(figsize=PAGE)
        figure.suptitle(title, fontsize=12, y=0.98)
        figure.subplots_adjust(0.03, 0.03, 0.97, 0.94, 0.05, 0.35)
        for place in np.ndindex(rows, columns):
            axes = figure.add_subplot(rows, columns, place[0] * columns + place[1] + 1)
            axes.set_axis_off()
            if place in meshes:
                axes.imshow(render(meshes[place], PIXELS))
            name, size = captions.get(place, ("", ""))
            below: dict[str, Any] = {"ha": "center", "va": "top", "transform": axes.transAxes}
            axes.text(0.5, -0.02, name, color=INK, weight="bold", **below)
            axes.text(0.5, -0.17, size, color=SOFT, fontsize=6.5, **below)
        buffer = io.BytesIO()
        dates = {"CreationDate": None, "Producer": None, "Creator": None}
        figure.savefig(buffer, format="pdf", metadata=dates, dpi=PIXELS)
    return buffer.getvalue()
