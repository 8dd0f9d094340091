"""naive-grasp: naive grasps of the objects of a shard, in free space and on a table."""

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from egad._util.progress import phase, progress
from egad.bench import ENGINE_TIME, NaiveGrasps, naive_outcomes, try_naive_grasps
from egad.exchange import model_of_parts
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.grasping import NAIVE_GRASPS
from egad.tables.outcomes import Outcome
from egad_workflow.job import run_job
from egad_workflow.restarting_worker import RestartingWorker

log = logging.getLogger(__name__)

GRASP_TIME = 5.0  # seconds; a grasp takes a tenth of that


def run(settings: NaiveGrasps, convex_parts: Path, meshes: Path, out: Path) -> None:
    """Try naive grasps of the objects of a shard that have convex parts."""
    names = parquet.read(convex_parts, CONVEX_PARTS)[["label", "id"]].drop_duplicates()
    count = settings.naive_grasp.grasps
    crashed = [Outcome.CRASHED] * count
    found = []
    phase("starting the simulator")
    opened = partial(open_naive_grasps, settings, convex_parts, meshes)
    with RestartingWorker(opened, ENGINE_TIME + 2 * count * GRASP_TIME) as attempt:
        for row in progress(parquet.records(names), "trying naive grasps", len(names)):
            tried = attempt(row)
            if tried is None:
                tried = naive_outcomes(crashed, crashed, settings)
            found.append(tried.assign(**row))
    table = pd.concat(found) if found else parquet.empty(NAIVE_GRASPS)
    parquet.write(table, NAIVE_GRASPS, out)
    succeeded = int((table["outcome"] == Outcome.SUCCESS).sum())
    log.info("%d naive grasps, %d succeeded", len(table), succeeded)


@contextmanager
def open_naive_grasps(
    settings: NaiveGrasps, convex_parts: Path, meshes: Path
) -> Iterator[Callable[[Mapping[str, Any]], pd.DataFrame]]:
    """A function that tries naive grasps of an object, given its label and id."""
    parts = dict(iter(parquet.read(convex_parts, CONVEX_PARTS).groupby("label")))

    def attempt(row: Mapping[str, Any]) -> pd.DataFrame:
        label, density = row["label"], settings.material.density
        model = model_of_parts(meshes / f"{label}.obj", density, parts[label])
        return try_naive_grasps(model, row["id"], settings)

    yield attempt


if __name__ == "__main__":
    run_job(run)
