"""simulated-success-rate: how often simulated grasps of each object succeed."""

from pathlib import Path

from egad.errors import UserError
from egad.exchange import is_simulated
from egad.sim import antipodal_success_rates, naive_success_rates
from egad.tables import parquet
from egad.tables.grasping import NAIVE_GRASPS, SIMULATED_GRASPS, SIMULATED_OBJECTS
from egad_workflow.job import run_job


def run(grasps: Path, naive: Path, out: Path) -> None:
    """Count how often the naive and the antipodal grasps of each object succeed in simulation."""
    if not is_simulated(grasps):
        raise UserError(f"{grasps} has no simulated labels; set targets.simulated_labels: true")
    held = antipodal_success_rates(parquet.read(grasps, SIMULATED_GRASPS))
    rates = naive_success_rates(parquet.read(naive, NAIVE_GRASPS))
    # An object may have no antipodal grasps, or none whose outcome the engine could determine.
    table = rates.merge(held, how="outer", on=["label", "id"], sort=True)
    counts = {name: table[name].fillna(0) for name in ("n_free", "n_table", "n_simulated")}
    parquet.write(table.assign(**counts), SIMULATED_OBJECTS, out)


if __name__ == "__main__":
    run_job(run)
