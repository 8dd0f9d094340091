"""release-tables: the tables of a dataset release, in splits by family."""

import logging
from collections import Counter
from pathlib import Path

import pandas as pd

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad.evalset import families, split_by_family, with_parents_and_children
from egad.evolution import Lineage
from egad.exchange.release import (
    ReleaseTables,
    in_files,
    released_grasps,
    released_objects,
    simulated_grasps,
)
from egad.learning.images import SPLITS
from egad.sim import antipodal_success_rates
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.evolution import LINEAGE
from egad.tables.grasping import ANTIPODAL_RATES, SCALES, SIMULATED_GRASPS
from egad.tables.objects import OBJECTS
from egad.tables.release import RELEASED_EVALUATION_SET, RELEASED_GRASPS, RELEASED_OBJECTS
from egad_workflow.job import run_job

log = logging.getLogger(__name__)


def run(
    settings: ReleaseTables,
    objects: Path,
    scales: Path,
    evaluation: Path,
    grasps: list[Path],
    out: Path,
    ancestry: Path | None = None,
) -> None:
    """Write the objects, the grasps with simulated labels, and the evaluation set of a release."""
    known = parquet.read(objects, OBJECTS)
    chosen = parquet.read(evaluation, EVAL49)
    found, simulated = _grasps(grasps, settings.release.grasps)
    table = released_objects(
        known, parquet.read(scales, SCALES), simulated, Counter(found["label"]), chosen["id"]
    )
    lineage = Lineage(parquet.read(ancestry, LINEAGE)) if ancestry else None
    family_of = families(table["id"], lineage)
    test = with_parents_and_children(chosen["id"], lineage)
    split_of = split_by_family(family_of, test, settings.release.validation, settings.seed)
    table = table.assign(
        split=table["id"].map(split_of),
        family=table["id"].map(family_of),
        gripper=settings.release.gripper,
    )
    found = found.assign(split=found["id"].map(split_of))
    with atomic_output(out) as folder:
        parquet.write(table, RELEASED_OBJECTS, folder / "objects.parquet")
        parquet.write(found, RELEASED_GRASPS, folder / "grasps.parquet")
        for split in SPLITS:
            rows, mine = (each[each["split"] == split] for each in (table, found))
            parquet.write(rows, RELEASED_OBJECTS, folder / "objects" / f"{split}.parquet")
            for name, part in in_files(mine, split):
                parquet.write(part, RELEASED_GRASPS, folder / "grasps" / name)
            log.info("%s: %d objects, %d grasps", split, len(rows), len(mine))
        named = chosen.join(table.set_index("id")[["mesh", "preview"]], on="id")
        parquet.write(named, RELEASED_EVALUATION_SET, folder / "evaluation_set.parquet")


def _grasps(shards: list[Path], most: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The released grasps of all objects, sorted, and how often the grasps of each object held."""
    found, summaries = [], []
    for path in progress(shards, "reading grasps", len(shards)):
        table = parquet.read(path, SIMULATED_GRASPS)
        found.append(released_grasps(simulated_grasps(table, most)))
        summaries.append(antipodal_success_rates(table))
    grasps = _joined(found, RELEASED_GRASPS.names).sort_values(["label", "grasp"])
    return grasps.reset_index(drop=True), _joined(summaries, ANTIPODAL_RATES.names)


def _joined(frames: list[pd.DataFrame], columns: list[str]) -> pd.DataFrame:
    filled = [frame for frame in frames if len(frame)]
    return pd.concat(filled, ignore_index=True) if filled else pd.DataFrame(columns=columns)


if __name__ == "__main__":
    run_job(run)
