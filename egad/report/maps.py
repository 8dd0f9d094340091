"""The map of a dataset and its evaluation set, laid out for the templates."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from egad.evalset.parameters import SelectEval
from egad.evalset.selection import label_at
from egad.measures.grid import cell_name
from egad.measures.parameters import Space
from egad.report.data import DatasetReport
from egad.report.style import scale_colour

SHOWN = 4
BY_CELL = ["difficulty_cell", "complexity_cell"]
STOPS = 11
CLIPPED = 0.02


@dataclass(frozen=True)
class Cell:
    """A filled cell of the map: its place, its colour, and its objects, most diverse first."""

    column: int
    row: int
    name: str
    count: int
    diversity: float
    colour: str
    picture: str


@dataclass(frozen=True)
class SpaceMap:
    """The cells of a dataset, the colour bar, and what a click on a cell shows.

    Attributes:
        size: Cells along each axis.
        cells: The filled ones.
        low: Mean diversity at the lower end of the colour bar, passed by few cells.
        high: Mean diversity at its upper end.
        stops: Colours of the bar, from low to high.
        details: Objects of each cell by its name: label, id, complexity, difficulty, diversity
            and picture (base64; None for the first, which the map shows); then how many more.
        first: Name of the cell whose objects are shown first.
        pictured: Whether the objects have pictures.
    """

    size: int
    cells: list[Cell]
    low: float
    high: float
    stops: list[str]
    details: dict[str, dict[str, Any]]
    first: str
    pictured: bool


@dataclass(frozen=True)
class Place:
    """A place of the evaluation set; `item` is None if the archive could not fill it."""

    label: str
    item: Mapping[str, Any] | None
    picture: str


def data_uri(content: bytes, kind: str = "image/png") -> str:
    """Content as an address that needs no file; empty for no content."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}" if content else ""


def shown_objects(objects: pd.DataFrame) -> list[str]:
    """Labels of the objects that the map has pictures of: the most diverse ones of each cell."""
    labels: list[str] = _ordered(objects).groupby(BY_CELL).head(SHOWN)["label"].tolist()
    return labels


def _ordered(objects: pd.DataFrame) -> pd.DataFrame:
    return objects.sort_values(["diversity", "label"], ascending=[False, True])


def space_map(data: DatasetReport, space: Space) -> SpaceMap:
    """Lay out the objects of a dataset over the space.

    A cell has the colour of the mean diversity of its objects and the picture of the most
    diverse one.
    """
    ordered = _ordered(data.objects)
    groups = list(ordered.groupby(BY_CELL, sort=True))
    means = [float(group["diversity"].mean()) for _, group in groups]
    known = [mean for mean in means if not np.isnan(mean)]
    low, high = np.quantile(known, [CLIPPED, 1 - CLIPPED]) if known else (0.0, 0.0)
    cells, details = [], {}
    for (_, group), mean in zip(groups, means, strict=True):
        cell = _cell(group, mean, scale_colour(mean, low, high), data.pictures)
        cells.append(cell)
        details[cell.name] = _details(group, data.pictures)
    stops = [scale_colour(stop, 0, STOPS - 1) for stop in range(STOPS)]
    first = _name(ordered.iloc[0]) if len(ordered) else ""
    return SpaceMap(
        space.cells, cells, float(low), float(high), stops, details, first, bool(data.pictures)
    )


def _name(item: Mapping[str, Any] | pd.Series) -> str:
    return cell_name(item["complexity_cell"], item["difficulty_cell"])


def _cell(group: pd.DataFrame, mean: float, colour: str, pictures: Mapping[str, bytes]) -> Cell:
    best = group.iloc[0]
    return Cell(
        column=int(best["complexity_cell"]),
        row=int(best["difficulty_cell"]),
        name=_name(best),
        count=len(group),
        diversity=mean,
        colour=colour,
        picture=data_uri(pictures.get(best["label"], b"")),
    )


def _details(group: pd.DataFrame, pictures: Mapping[str, bytes]) -> dict[str, Any]:
    items = []
    for rank, item in enumerate(group.head(SHOWN).to_dict("records")):
        picture = pictures.get(item["label"], b"") if rank else b""
        items.append(
            [
                item["label"],
                item["id"],
                _rounded(item["complexity"], 4),
                _rounded(item["difficulty"], 6),
                _rounded(item["diversity"], 4),
                base64.b64encode(picture).decode() or None,
            ]
        )
    return {"items": items, "more": max(0, len(group) - SHOWN)}


def _rounded(value: float, digits: int) -> float | None:
    return None if np.isnan(value) else round(float(value), digits)


def evaluation_grid(data: DatasetReport, layout: SelectEval) -> list[list[Place]]:
    """Rows of the evaluation set, hardest first; each from simplest to most complex."""
    chosen: dict[str, Mapping[Any, Any]] = {}
    if data.evalset is not None:
        chosen = {item["label"]: item for item in data.evalset.to_dict("records")}
    grid = []
    for row in reversed(range(layout.rows)):
        labels = [label_at(row, column) for column in range(layout.columns)]
        grid.append([_place(label, chosen.get(label), data) for label in labels])
    return grid


def _place(label: str, item: Mapping[Any, Any] | None, data: DatasetReport) -> Place:
    if item is None:
        return Place(label, None, "")
    small = data.pictures.get(item["object_label"], b"")
    return Place(label, item, data_uri(data.evalset_pictures.get(label, small)))
