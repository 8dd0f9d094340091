"""simulated-graspability: how often the simulated grasps of each object hold."""

from pathlib import Path

from egad.errors import UserError
from egad.exchange import is_simulated
from egad.grasps import simulated_graspability
from egad.tables import parquet
from egad.tables.grasping import SIMULATED_GRASPS, SIMULATED_OBJECTS
from egad.workflow.job import run_job


def run(
    grasps: Path,
    out: Path,
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
    parquet.write(simulated_graspability(table), SIMULATED_OBJECTS, out)


if __name__ == "__main__":
    run_job(run)
