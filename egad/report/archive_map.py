"""The map of an archive, with a picture of an object in each cell."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from egad.evolution import Archive, Elite, unpack
from egad.measures import MeasureSpace, cell_name, complexity_cells, difficulty_cells
from egad.report.axes import USUAL, AxisPair, named_axes
from egad.report.page import counted, data_uri, render_template
from egad.report.pictures import voxel_picture, voxel_png

UNIT = 40  # side of a cell of the map, pixels
MARGIN = 4  # pixels of a cell that its picture leaves free
MAX_SIDE = 96  # side of a picture, pixels
NARROWEST = 520  # minimum side of a map, pixels; cells of smaller maps are enlarged
Cells = dict[str, tuple[int, str]]  # by name: how many objects, and a picture of one


def _pictured_cells(elites: Sequence[Elite], space: MeasureSpace, size: int) -> Cells:
    """Number of elites, oldest first, and a picture of the oldest, by name of the cell."""
    columns = complexity_cells([elite.complexity for elite in elites], space)
    rows = difficulty_cells([elite.graspability for elite in elites], space)
    names = [cell_name(int(column), int(row)) for column, row in zip(columns, rows, strict=True)]
    counts, first = Counter(names), dict[str, Elite]()
    for name, elite in zip(names, elites, strict=True):
        first.setdefault(name, elite)
    return {
        name: (
            counts[name],
            picture_of(each.voxels, round((8 * len(each.voxels)) ** (1 / 3)), size),
        )
        for name, each in first.items()
    }


def picture_of(packed: bytes, resolution: int, size: int = UNIT - MARGIN) -> str:
    """A picture of voxels as archives keep them, for the attribute `href` of an image."""
    return data_uri(voxel_png(voxel_picture(unpack(packed, resolution), size)))


def archive_map(archive: Archive, measures: tuple[str, str] | None = None) -> str:
    """SVG map of an archive, with the oldest object of each cell; axes are named by measures."""
    unit = max(UNIT, NARROWEST // archive.space.cells)
    cells = _pictured_cells(archive.elites, archive.space, min(unit - MARGIN, MAX_SIDE))
    axes = USUAL if measures is None else named_axes(*measures)
    caption = (
        f"{counted(len(archive), 'object')} in {len(cells)} of {archive.space.cells**2} cells, "
        f"coverage {100 * archive.coverage:.1f} %; darker: more objects"
    )
    values = map_values(cells, archive.space, axes)
    return render_template("archive_map.svg.j2", **values, unit=unit, caption=caption)


def map_values(cells: Cells, space: MeasureSpace, axes: AxisPair) -> dict[str, Any]:
    """What the template of the map reads besides the size of a cell and a caption."""
    size = range(space.cells)
    (start, end), (hard, easy) = space.complexity_range, space.graspability_range
    return {
        "cells": cells,
        "size": space.cells,
        "capacity": space.elites_per_cell,
        "names": [[cell_name(column, row) for column in size] for row in size],
        "across": axes.across.along(start, end),
        "upwards": axes.upwards.along(easy, hard),
    }
