"""simulated-label: labelled grasps of the objects of a shard, closed, shaken and lifted."""

import logging
from functools import partial
from pathlib import Path

import pandas as pd

from egad._util.child_process import RestartingWorker
from egad._util.progress import phase, progress
from egad.config.stages import SimulatedLabels
from egad.tables import parquet
from egad.tables.grasping import GRASPS, SIMULATED_GRASPS
from egad.tables.outcomes import Outcome
from egad.workflow.bundled import ENGINE_TIME
from egad.workflow.job import run_job
from egad.workflow.simulations import failed_labels, open_labels

log = logging.getLogger(__name__)


def run(
    settings: SimulatedLabels, grasps: Path, convex_parts: Path, meshes: Path, out: Path
) -> None:
    """Simulate the grasps of the objects of a shard: closed in free space, shaken and lifted.

    Everything runs in a separate process. If an object crashes it twice, its grasps are marked as
    crashed.
    """
    labelled = parquet.read(grasps, GRASPS)
    found = []
    phase("starting the simulator")
    limit = ENGINE_TIME * settings.simulated_label.grasps
    objects = labelled.groupby("label")
    with RestartingWorker(partial(open_labels, settings, convex_parts, meshes), limit) as simulate:
        for _, rows in progress(objects, "simulating grasps", objects.ngroups):
            labels = simulate(rows)
            if labels is None:
                labels = failed_labels(rows, settings, Outcome.CRASHED)
            found.append(labels)
    whole = pd.concat(found) if found else parquet.empty(SIMULATED_GRASPS)
    parquet.write(whole, SIMULATED_GRASPS, out)
    known = whole["simulated_success"].dropna()
    log.info("%d grasps simulated, %d held", len(known), int(known.sum()))


if __name__ == "__main__":
    run_job(run)
