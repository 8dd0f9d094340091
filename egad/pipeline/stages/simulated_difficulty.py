"""simulated-difficulty: how often the simulated grasps of each object hold."""

from pathlib import Path
from typing import Annotated

from egad.errors import UserError
from egad.exchange import is_simulated
from egad.grasps import simulated_difficulty
from egad.pipeline.parameters import Input, Output, command
from egad.tables import parquet
from egad.tables.grasping import SIMULATED_GRASPS, SIMULATED_OBJECTS


@command()
def run(
    grasps: Annotated[Path, Input()],
    out: Annotated[Path, Output("D/simulated/G.parquet", SIMULATED_OBJECTS)],
) -> None:
    """Summarize the simulated labels of each object.

    Args:
        grasps: Labelled grasps with simulated labels.
        out: How often the simulated grasps of each object held, for gripper G. Made if
            `targets.simulated_labels` is true.

    Raises:
        UserError: The grasps have no simulated labels.
    """
    if not is_simulated(grasps):
        raise UserError(f"{grasps} has no simulated labels; set targets.simulated_labels: true")
    table = parquet.read(grasps, SIMULATED_GRASPS)
    parquet.write(simulated_difficulty(table), SIMULATED_OBJECTS, out)
