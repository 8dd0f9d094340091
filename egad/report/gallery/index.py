"""The index of the gallery: what the first view shows, searches and filters."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from egad.grippers import Gripper
from egad.measures import MeasureSpace
from egad.report.axes import AxisPair, MeasureAxis
from egad.report.gallery.files import FOLDER, SHEETS, cell_ranks, file_link, rounded


@dataclass(frozen=True)
class Membership:
    """What objects belong to besides their cells, and what simulation says about their grasps."""

    # name of the family by id of the object; empty if families are unknown
    families: Mapping[str, str]
    places: Mapping[str, str]  # label in the evaluation set by id of the object
    simulated: Mapping[str, float]  # fraction of the simulated grasps that held, by id


def index_data(
    objects: pd.DataFrame,
    space: MeasureSpace,
    axes: AxisPair,
    member: Membership,
    gripper: Gripper | None = None,
    unattainable: int = 0,
) -> dict[str, Any]:
    """The data of the first view of the gallery, ready for JSON; `finger` in metres."""
    ranks = cell_ranks(objects)
    measures = _measures(axes, bool(member.simulated))
    ids = objects["id"]
    values = objects.assign(simulated=ids.map(dict(member.simulated)))
    columns = {
        "label": objects["label"].tolist(),
        "id": ids.tolist(),
        "column": objects["complexity_cell"].tolist(),
        "row": objects["difficulty_cell"].tolist(),
        "rank": ranks.tolist(),
        "family": [member.families.get(each, "") for each in ids],
        "place": [member.places.get(each, "") for each in ids],
        "error": [rounded(value) for value in objects["graspability_std"]],
    }
    for measure in measures:
        key = str(measure["key"])
        columns[key] = [rounded(value) for value in values[key]]
    return {
        "finger": _finger(gripper),
        "cells": space.cells,
        "unattainable": unattainable,
        "sheets": [
            file_link(FOLDER, SHEETS, f"{rank}.webp")
            for rank in range(int(ranks.max(initial=-1)) + 1)
        ],
        "measures": measures,
        "columns": columns,
    }


def _finger(gripper: Gripper | None) -> float:
    if gripper is None:
        return 0.0
    return -gripper.kind.span[0]


def _measures(axes: AxisPair, simulated: bool) -> list[dict[str, Any]]:
    """What can be filtered, with the names and units of the axes."""
    found = [_measure("complexity", axes.across), _measure("graspability", axes.upwards)]
    if simulated:
        found.append(_entry("simulated", "antipodal success", "%", 100, 0))
    return [*found, _entry("diversity", "diversity", "", 1, 3)]


def _measure(key: str, axis: MeasureAxis) -> dict[str, Any]:
    return _entry(key, axis.value, axis.printed_unit, axis.factor, 2)


def _entry(key: str, name: str, unit: str, factor: int, decimals: int) -> dict[str, Any]:
    return {"key": key, "name": name, "unit": unit, "factor": factor, "decimals": decimals}
