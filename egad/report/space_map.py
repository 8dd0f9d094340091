"""The section Map: the objects of each dataset over the space."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from egad.measures import Attainable, MeasureSpace, cell_name
from egad.report.axes import AxisPair, MeasureAxis
from egad.report.colors import scale_color
from egad.report.page import Section, data_uri, section_of

SHOWN = 4  # objects of a cell with a picture
BY_CELL = ["difficulty_cell", "complexity_cell"]
STOPS = 11
CLIPPED = 0.02


@dataclass(frozen=True)
class Cell:
    """A filled cell of the map: position, color, and its most diverse object."""

    column: int
    row: int
    name: str
    count: int
    diversity: float
    confidence: float  # mean probability that its objects belong there; NaN if unknown
    color: str
    picture: str


@dataclass(frozen=True)
class SpaceMap:
    """The cells of a dataset, the color bar, and what a click on a cell shows."""

    size: int  # cells along each axis
    cells: list[Cell]  # the filled ones
    low: float  # mean diversity at the lower end of the color bar; few cells are below it
    high: float  # mean diversity at its upper end
    stops: list[str]  # colors of the bar, from low to high
    # objects of each cell by its name: label, id, complexity, graspability, its standard
    # error, confidence of the cell, diversity and picture (base64; None for the first, which
    # the map shows); then the number of further objects
    details: dict[str, dict[str, Any]]
    first: str  # name of the cell whose objects are shown first
    pictured: bool  # whether the objects have pictures


def section(
    maps: Mapping[str, SpaceMap], space: MeasureSpace, axes: AxisPair, limit: Attainable
) -> Section:
    """The maps of all datasets, from `space_map`; rows outside of `limit` are hatched."""
    certain = any(cell.confidence >= 0 for each in maps.values() for cell in each.cells)
    values = {"space": space, "axes": axes, "certain": certain}
    hatched, legend = limit.rows, legend_of(limit, axes.upwards)
    return section_of("map.html.j2", "Map", maps=maps, hatched=hatched, legend=legend, **values)


def legend_of(limit: Attainable, axis: MeasureAxis) -> str:
    """A legend for the hatched rows of a map along the axis upwards; empty if there are none."""
    if not limit.rows:
        return ""
    edge, best, most = (
        f"{axis.factor * value:.2f}" for value in (limit.edge, limit.quality, limit.graspability)
    )
    return (
        f"Hatched: no object is expected in {limit.row_names}. Graspability is a percentile of the "
        f"quality of grasps. It would have to be {edge} {axis.printed_unit} or more there. A grasp "
        f"has at most {best}, and the percentile of an object that is as thick as its box is "
        f"expected to be at most {most}."
    )


def shown_objects(objects: pd.DataFrame) -> list[str]:
    """Labels of the objects that the map has pictures of: the most diverse ones of each cell."""
    labels: list[str] = _by_diversity(objects).groupby(BY_CELL).head(SHOWN)["label"].tolist()
    return labels


def _by_diversity(objects: pd.DataFrame) -> pd.DataFrame:
    return objects.sort_values(["diversity", "label"], ascending=[False, True])


def space_map(
    objects: pd.DataFrame, pictures: Mapping[str, bytes], space: MeasureSpace
) -> SpaceMap:
    """Lay out `OBJECTS` over the space by diversity, with PNGs by label of `shown_objects`."""
    ordered = _by_diversity(objects)
    groups = list(ordered.groupby(BY_CELL, sort=True))
    means = [float(group["diversity"].mean()) for _, group in groups]
    known = [mean for mean in means if not np.isnan(mean)]
    low, high = np.quantile(known, [CLIPPED, 1 - CLIPPED]) if known else (0.0, 0.0)
    cells, details = [], {}
    for (_, group), mean in zip(groups, means, strict=True):
        cell = _cell(group, mean, scale_color(mean, low, high), pictures)
        cells.append(cell)
        details[cell.name] = _details(group, pictures)
    stops = [scale_color(stop, 0, STOPS - 1) for stop in range(STOPS)]
    first = _name(ordered.iloc[0]) if len(ordered) else ""
    return SpaceMap(
        space.cells, cells, float(low), float(high), stops, details, first, bool(pictures)
    )


def _name(item: Mapping[str, Any] | pd.Series) -> str:
    return cell_name(item["complexity_cell"], item["difficulty_cell"])


def _cell(group: pd.DataFrame, mean: float, color: str, pictures: Mapping[str, bytes]) -> Cell:
    best = group.iloc[0]
    return Cell(
        column=int(best["complexity_cell"]),
        row=int(best["difficulty_cell"]),
        name=_name(best),
        count=len(group),
        diversity=mean,
        confidence=float(group["cell_confidence"].mean()),
        color=color,
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
                _round(item["complexity"], 4),
                _round(item["graspability"], 6),
                _round(item["graspability_std"], 6),
                _round(item["cell_confidence"], 3),
                _round(item["diversity"], 4),
                base64.b64encode(picture).decode() or None,
            ]
        )
    return {"items": items, "more": max(0, len(group) - SHOWN)}


def _round(value: float, digits: int) -> float | None:
    return None if np.isnan(value) else round(float(value), digits)
