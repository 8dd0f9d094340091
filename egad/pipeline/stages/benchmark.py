"""benchmark: a detector clears tables of any objects, with the settings of a configuration."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from egad.benchmark import Benchmark, check_detector, clear_tables, prepare_objects
from egad.detectors import keep_failure
from egad.named_meshes import NamedMesh
from egad.pipeline.parameters import Input, Jobs, NotNoted, Output
from egad.pipeline.stages.clutter import ClearedTables
from egad.tables import parquet
from egad.tables.clutter import CLUTTER


def run(
    settings: ClearedTables,
    objects: str,
    rule: str,
    targets: Annotated[Sequence[NamedMesh], NotNoted()],
    files: Annotated[list[Path], Input()],
    out: Annotated[Path, Output(schema=CLUTTER)],
    jobs: Jobs = 1,
) -> Benchmark:
    """Let a detector clear tables, and write a table of its attempts.

    Args:
        settings: Settings of the benchmark.
        objects: What the objects are called together.
        rule: How they are scaled: see `egad.rescale`.
        targets: The objects.
        files: The files that they come from, for the provenance.
        out: One attempt per row.
        jobs: Processes; the result does not depend on it.
    """
    del objects, files
    label_seed = settings.seed if settings.detector.detector == "labels" else None
    check_detector(settings.detector, settings)
    known = prepare_objects(targets, settings.gripper, rule, label_seed, jobs)
    with keep_failure(out):
        found = clear_tables(settings.detector, known, settings, jobs)
    parquet.write(found.table, CLUTTER, out)
    return found
