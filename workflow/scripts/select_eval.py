"""select-eval: the evaluation set of a dataset."""

import logging
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh

from egad._util.progress import phase, progress
from egad.errors import RejectedError
from egad.evalset import (
    Distances,
    EvalSelection,
    Selection,
    best_of_random,
    bound,
    coarse_cells,
    empty_cells,
    in_grid,
    label_at,
    labels_by_name,
    mean_distance,
    print_problems,
    read_labels,
    select,
    take,
    take_all,
)
from egad.geometry import rescale
from egad.measures.reeb import graph as reeb
from egad.measures.reeb import similarity_matrix
from egad.random import generator
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.objects import OBJECTS, REJECTED, SOLIDS, rejection
from egad_workflow.job import run_job
from egad_workflow.shards import join

log = logging.getLogger(__name__)


def run(
    settings: EvalSelection,
    objects: Path,
    solids: list[Path],
    labels: list[Path],
    selection: str,
    own: bool,
    out: Path,
    rejected: Path,
    jobs: int = 1,
) -> None:
    """Choose the evaluation set, or take all objects, or those that have already been chosen.

    A chosen set has one printable object per cell, which maximizes its dissimilarity. `all`: in the
    cells that objects are named after, if all are; `names`: those that are; `labels`: by a file.
    """
    frame = parquet.read(objects, OBJECTS)
    rows = join(solids, SOLIDS, ["id"]).set_index("id").loc[frame["id"]]
    graphs = [reeb.unpack(packed) for packed in rows["graph"]]
    watch = partial(progress, what="comparing objects", total=len(graphs))
    distances = 1 - similarity_matrix(graphs, settings.similarity.weight, jobs, watch)
    if selection != "cells":
        taken = _taken(frame, selection, labels, distances, settings)
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
    if own:
        left_out += _others(frame, found, settings)
    parquet.write(found.table, EVAL49, out)
    parquet.write(pd.DataFrame(left_out), REJECTED, rejected)
    _log_result(found, distances, settings)


def _taken(
    frame: pd.DataFrame,
    selection: str,
    labels: list[Path],
    distances: Distances,
    settings: EvalSelection,
) -> pd.DataFrame:
    """The set that nothing is chosen for; a warning names labels without an object."""
    if selection == "all" and (frame.empty or not in_grid(frame["id"])):
        return take_all(frame, distances, settings.select_eval, settings.space)
    known = read_labels(labels[0]) if labels else labels_by_name(frame["id"])
    taken = take(frame, known, distances, settings.select_eval)
    if empty := empty_cells(taken, settings.select_eval):
        log.warning("%d labels without an object: %s", len(empty), " ".join(empty))
    return taken


def _others(frame: pd.DataFrame, found: Selection, settings: EvalSelection) -> list[dict[str, str]]:
    """The objects whose cell has another, with that as the reason."""
    cells = coarse_cells(frame, settings.select_eval, settings.space)
    chosen = found.table.set_index("label")["id"]
    left_out = []
    for place in sorted(set(range(len(frame))) - set(found.chosen) - set(found.left_out)):
        label = label_at(*divmod(int(cells[place]), settings.select_eval.columns))
        reason = f"its cell {label} has another object: {chosen[label]}"
        left_out.append(rejection(frame["id"][place], "select-eval", reason))
    return left_out


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
