"""select-eval: the evaluation set of a dataset."""

import logging
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh

from egad._util.progress import phase, progress
from egad.config.stages import EvalSelection
from egad.errors import RejectedError
from egad.evalset import (
    Distances,
    Selection,
    best_of_random,
    bound,
    empty_cells,
    labels_by_name,
    mean_distance,
    print_problems,
    read_labels,
    select,
    take,
)
from egad.geometry import rescale
from egad.random import generator
from egad.reeb import graph as reeb
from egad.reeb import similarity_matrix
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.objects import OBJECTS, REJECTED, SOLIDS
from egad.workflow.job import run_job
from egad.workflow.shards import join, rejection

log = logging.getLogger(__name__)


def run(
    settings: EvalSelection,
    objects: Path,
    solids: list[Path],
    labels: list[Path],
    by_name: bool,
    out: Path,
    rejected: Path,
    jobs: int = 1,
) -> None:
    """Choose the evaluation set, or take one that has already been chosen.

    It has one printable object per cell. The choice maximizes the dissimilarity of the set.

    Args:
        settings: Settings of this stage.
        objects: Objects of the dataset.
        solids: Objects of the shards, from postprocess, for their Reeb graphs and meshes.
        labels: Labels of objects by id, if the set has already been chosen.
        by_name: Whether the set consists of the objects whose names are labels.
        out: The evaluation set.
        rejected: The candidates that cannot be printed, with reasons.
        jobs: Threads; the result does not depend on it.
    """
    frame = parquet.read(objects, OBJECTS)
    rows = join(solids, SOLIDS, ["id"]).set_index("id").loc[frame["id"]]
    graphs = [reeb.unpack(packed) for packed in rows["graph"]]
    watch = partial(progress, what="comparing objects", total=len(graphs))
    distances = 1 - similarity_matrix(graphs, settings.similarity.weight, jobs, watch)
    if labels or by_name:
        known = read_labels(labels[0]) if labels else labels_by_name(frame["id"])
        taken = take(frame, known, distances, settings.select_eval)
        if empty := empty_cells(taken, settings.select_eval):
            log.warning("%d labels without an object: %s", len(empty), " ".join(empty))
        parquet.write(taken, EVAL49, out)
        parquet.write(parquet.empty(REJECTED), REJECTED, rejected)
        return
    phase("choosing objects and checking whether they can be printed")
    found = select(
        frame,
        distances,
        settings.select_eval,
        settings.space,
        generator(settings.seed, "select-eval"),
        lambda place: _problems(rows.iloc[place], settings),
    )
    left_out = [
        rejection(frame["id"][place], "select-eval", _reason(problems, settings))
        for place, problems in sorted(found.left_out.items())
    ]
    parquet.write(found.table, EVAL49, out)
    parquet.write(pd.DataFrame(left_out), REJECTED, rejected)
    _log_result(found, distances, settings)


def _problems(row: pd.Series, settings: EvalSelection) -> list[str]:
    """Why an object cannot be printed for the gripper that all must be printed for."""
    vertices, faces = np.reshape(row["vertices"], (-1, 3)), np.reshape(row["faces"], (-1, 3))
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    rule, opening = settings.rescale, settings.gripper.opening
    try:
        scaled, _ = rescale(mesh, rule.rule, opening, rule.side_fraction)
    except RejectedError as reason:
        return [str(reason)]
    return print_problems(scaled, settings.print_check)


def _reason(problems: list[str], settings: EvalSelection) -> str:
    """A sentence about an object that was left out."""
    opening = f"{1000 * settings.gripper.opening:g} mm"
    return f"not printable for an opening of {opening}: {', '.join(problems)}"


def _log_result(found: Selection, distances: Distances, settings: EvalSelection) -> None:
    """Log how much less alike the chosen objects are than others could be, and what is missing."""
    rng = generator(settings.seed, "random-eval-sets")
    log.info(
        "%d objects, mean distance %.4f; best of 1000 random sets, printable or not, %.4f; "
        "no set exceeds %.4f",
        len(found.chosen),
        mean_distance(found.chosen, distances),
        best_of_random(found.candidates, distances, rng),
        bound(found.candidates, distances),
    )
    if found.left_out:
        log.info("%d candidates cannot be printed", len(found.left_out))
    if borrowed := found.table.loc[found.table["borrowed"].astype(bool), "label"].tolist():
        log.info(
            "%d cells took an object from a neighboring cell: %s", len(borrowed), " ".join(borrowed)
        )
    if empty := empty_cells(found.table, settings.select_eval):
        log.info("%d cells without a printable object: %s", len(empty), " ".join(empty))


if __name__ == "__main__":
    run_job(run)
