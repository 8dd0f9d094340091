"""compare: datasets side by side, as in EGAD's Table III."""

from pathlib import Path

import pandas as pd

from egad import tables
from egad.measures.space import coverage, filled_cells
from egad.stage_settings import Compare


def run(settings: Compare, datasets: dict[str, Path], out: Path) -> None:
    """Coverage and diversity of each dataset.

    Args:
        settings: What this stage reads.
        datasets: Tables with the columns of `egad.tables.OBJECTS`, by name.
        out: Table with the columns of `egad.tables.COMPARISON`.
    """
    rows = []
    for name, path in datasets.items():
        objects = tables.read(path, tables.OBJECTS)
        diversity = objects["diversity"]
        rows.append(
            {
                "dataset": name,
                "objects": len(objects),
                "coverage": coverage(objects, settings.space),
                "filled_cells": filled_cells(objects, settings.space),
                "diversity_min": diversity.min(),
                "diversity_max": diversity.max(),
                "diversity_mean": diversity.mean(),
            }
        )
    tables.write(pd.DataFrame(rows), tables.COMPARISON, out)
