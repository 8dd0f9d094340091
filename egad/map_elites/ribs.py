"""An archive as pyribs lays out its own: for its tools, and for people who know these."""

import numpy as np
import pandas as pd

from egad.measures.parameters import Space


def ribs_frame(archive: pd.DataFrame, space: Space) -> pd.DataFrame:
    """The elites with the columns of a pyribs `ArchiveDataFrame`.

    Args:
        archive: Columns of `tables.evolution.ARCHIVE`.
        space: Its cells.

    Returns:
        A row an elite: `index` (of its cell: along complexity, then difficulty, both from the low
        end), `objective` (its diversity), `measures_0` (complexity), `measures_1` (difficulty,
        high is easy), `id`. Unlike in pyribs, a cell may have several rows.
    """
    rows = space.cells - 1 - archive["difficulty_cell"].to_numpy()  # the low end is hard
    shape = (space.cells, space.cells)
    return pd.DataFrame(
        {
            "index": np.ravel_multi_index((archive["complexity_cell"].to_numpy(), rows), shape),
            "objective": archive["diversity"].to_numpy(),
            "measures_0": archive["complexity"].to_numpy(),
            "measures_1": archive["difficulty"].to_numpy(),
            "id": archive["id"].to_numpy(),
        }
    )
