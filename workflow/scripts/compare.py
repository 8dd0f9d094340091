"""compare: a comparison of datasets, as in Table III of EGAD, with a map of each."""

from pathlib import Path
from typing import Any

import pandas as pd

from egad._util.files import write_text
from egad.measures import (
    Attainable,
    MeasureParameters,
    MeasureSpace,
    attainable_graspability,
    coverage,
    filled_cells,
)
from egad.report.axes import axis_pair
from egad.report.comparison import comparison_text, dataset_maps
from egad.tables import parquet
from egad.tables.objects import COMPARISON, OBJECTS
from egad_workflow.job import run_job


def run(
    settings: MeasureParameters, datasets: list[str], objects: list[Path], out: Path, figure: Path
) -> str:
    """Write coverage and diversity of datasets and their maps; return the table as text."""
    tables = {
        name: parquet.read(path, OBJECTS) for name, path in zip(datasets, objects, strict=True)
    }
    space, limit = settings.space, attainable_graspability(settings)
    comparison = pd.DataFrame([_row(name, each, space, limit) for name, each in tables.items()])
    parquet.write(comparison, COMPARISON, out)
    write_text(figure, dataset_maps(tables, space, axis_pair(settings.measures), limit.rows))
    return comparison_text(comparison)


def _row(
    name: str, objects: pd.DataFrame, space: MeasureSpace, limit: Attainable
) -> dict[str, Any]:
    diversity = objects["diversity"]
    return {
        "dataset": name,
        "objects": len(objects),
        "coverage": coverage(objects, space),
        "attainable_coverage": coverage(objects, space, limit.rows),
        "filled_cells": filled_cells(objects, space),
        "diversity_min": diversity.min(),
        "diversity_max": diversity.max(),
        "diversity_mean": diversity.mean(),
    }


if __name__ == "__main__":
    run_job(run)
