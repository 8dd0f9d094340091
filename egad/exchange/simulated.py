"""What the formats of simulated grasps share."""

from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from egad._util.progress import progress
from egad.errors import UserError
from egad.exchange.grasp_tables import by_object, is_simulated
from egad.tables import parquet
from egad.tables.grasping import SIMULATED_GRASPS

COLUMNS = [name for name in SIMULATED_GRASPS.names if name not in ("id", "label")]


def check_simulated(grasps: Path) -> None:
    """Raise UserError, which says how to get them, if grasps have no simulated labels."""
    if not is_simulated(grasps):
        raise UserError(
            f"{grasps} has no simulated labels, which this format needs: they say whether a grasp "
            "succeeded. Run the workflow with targets: {simulated_labels: true}"
        )


def simulated_by_object(grasps: Path) -> Iterator[tuple[str, pd.DataFrame]]:
    """The grasps of one object after the other, with progress: see `by_object`."""
    labels = parquet.distinct(grasps, "label")
    return progress(by_object(grasps, COLUMNS), "writing grasps", len(labels))
