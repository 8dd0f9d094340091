"""compare: a comparison of datasets, as in Table III of EGAD, with a map of each."""

from pathlib import Path
from typing import Annotated, Any

import pandas as pd
import typer

from egad._util.files import write_text
from egad.measures import (
    Attainable,
    MeasureParameters,
    Space,
    attainable_coverage,
    attainable_difficulty,
    coverage,
    filled_cells,
)
from egad.pipeline.parameters import Input, Output, command
from egad.report.axes import axis_pair
from egad.report.comparison import comparison_text, dataset_maps
from egad.tables import parquet
from egad.tables.objects import COMPARISON, OBJECTS


class Compare(MeasureParameters):
    """Datasets side by side, and the cells that the measures leave to objects."""


@command()
def run(
    settings: Compare,
    datasets: Annotated[dict[str, Path], typer.Argument(), Input(names="datasets")],
    out: Annotated[Path, Output("comparison.parquet", COMPARISON)],
    figure: Annotated[Path, Output("comparison.svg")],
) -> str:
    """Compare datasets: coverage and diversity, and a map of the objects of each.

    Args:
        settings: Settings of this stage.
        datasets: Objects of each dataset as NAME=objects.parquet.
        out: Coverage and diversity of all datasets.
        figure: A small map of each dataset: objects per cell, on a common scale.

    Returns:
        The table for a terminal, with the published numbers below.
    """
    objects = {name: parquet.read(path, OBJECTS) for name, path in datasets.items()}
    space, limit = settings.space, attainable_difficulty(settings)
    comparison = pd.DataFrame([_row(name, each, space, limit) for name, each in objects.items()])
    parquet.write(comparison, COMPARISON, out)
    write_text(figure, dataset_maps(objects, space, axis_pair(settings.measures), limit.rows))
    return comparison_text(comparison)


def _row(name: str, objects: pd.DataFrame, space: Space, limit: Attainable) -> dict[str, Any]:
    diversity = objects["diversity"]
    return {
        "dataset": name,
        "objects": len(objects),
        "coverage": coverage(objects, space),
        "attainable_coverage": attainable_coverage(objects, space, limit.rows),
        "filled_cells": filled_cells(objects, space),
        "diversity_min": diversity.min(),
        "diversity_max": diversity.max(),
        "diversity_mean": diversity.mean(),
    }
