"""The section Cleared tables: how well detectors clear tables of several objects."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from egad.report.drawing import data_uri
from egad.report.page import Section, section_of
from egad.stats import Clearing, Rate, by_difficulty, clearing_rates
from egad.tables import parquet


@dataclass(frozen=True)
class ClutterView:
    """Cleared tables of one gripper.

    Attributes:
        rates: Of each kind of scene and noise, by detector.
        thirds: Success of attempts, and share of objects that were cleared, by detector, axis
            (complexity, difficulty) and third of the objects.
        pictures: Addresses of pictures of scenes at the beginning of a round, by kind.
    """

    rates: dict[str, list[Clearing]]
    thirds: dict[str, dict[str, list[tuple[Rate, Rate]]]]
    pictures: dict[str, list[str]]


def section(datasets: Mapping[str, Mapping[str, ClutterView]], *, named: bool) -> Section:
    """Cleared tables of each dataset with each gripper.

    Args:
        datasets: From `clutter_view`, by dataset and gripper.
        named: Whether to write the name of each dataset.
    """
    return section_of("clutter.html.j2", "Cleared tables", datasets=datasets, named=named)


def clutter_view(
    tables: Mapping[str, pd.DataFrame],
    objects: pd.DataFrame,
    pictures: Mapping[str, Sequence[bytes]],
) -> ClutterView:
    """Work out what there is to show.

    Args:
        tables: Columns of `tables.clutter.CLUTTER`, by detector.
        objects: Columns id, complexity and difficulty of the objects in the scenes.
        pictures: PNGs of scenes, by kind.
    """
    return ClutterView(
        {name: clearing_rates(table) for name, table in tables.items()},
        {name: _thirds(table, objects) for name, table in tables.items()},
        {kind: [data_uri(png) for png in each] for kind, each in pictures.items()},
    )


def _thirds(table: pd.DataFrame, objects: pd.DataFrame) -> dict[str, list[tuple[Rate, Rate]]]:
    found: dict[str, list[tuple[Rate, Rate]]] = {}
    for row in parquet.records(by_difficulty(table, objects)):
        rates = tuple(Rate(row["successes"], row[of]) for of in ("attempts", "present"))
        found.setdefault(row["axis"], []).append((rates[0], rates[1]))
    return found
