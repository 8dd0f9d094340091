"""simulated-label: labelled grasps of the objects of a shard, closed, shaken and lifted."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pandas as pd

from egad._util.progress import phase, progress
from egad.bench import ENGINE_TIME
from egad.exchange import model_of_parts
from egad.sim import (
    SimulatedGrasp,
    SimulatedLabels,
    chosen_grasps,
    simulate_labels,
    with_simulated_labels,
)
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.grasping import GRASPS, SIMULATED_GRASPS
from egad.tables.outcomes import Outcome
from egad_workflow.job import run_job
from egad_workflow.restarting_worker import RestartingWorker

log = logging.getLogger(__name__)


def run(
    settings: SimulatedLabels, grasps: Path, convex_parts: Path, meshes: Path, out: Path
) -> None:
    """Simulate the grasps of the objects of a shard: closed in free space, shaken and lifted."""
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


@contextmanager
def open_labels(
    settings: SimulatedLabels, convex_parts: Path, meshes: Path
) -> Iterator[Callable[[pd.DataFrame], pd.DataFrame]]:
    """A function that adds simulated labels to the grasps of an object."""
    parts = dict(iter(parquet.read(convex_parts, CONVEX_PARTS).groupby("label")))

    def simulate(rows: pd.DataFrame) -> pd.DataFrame:
        label = rows["label"].iloc[0]
        if label not in parts:
            log.warning("%s cannot be simulated: it has no convex parts", label)
            return failed_labels(rows, settings, Outcome.FAILED)
        density = settings.material.density
        model = model_of_parts(meshes / f"{label}.obj", density, parts[label])
        return simulate_labels(model, rows, settings)

    yield simulate


def failed_labels(rows: pd.DataFrame, settings: SimulatedLabels, outcome: Outcome) -> pd.DataFrame:
    """The grasps of an object for which no grasp could be simulated."""
    chosen = chosen_grasps(rows, settings)
    return with_simulated_labels(rows, chosen, [SimulatedGrasp(outcome)] * len(chosen), settings)


if __name__ == "__main__":
    run_job(run)
