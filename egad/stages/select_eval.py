"""select-eval: the evaluation set of a dataset."""

import logging
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.evalset.selection import (
    best_of_random,
    candidates_by_cell,
    empty_cells,
    mean_distance,
    select,
)
from egad.measures import reeb
from egad.measures.similarity import similarity_matrix
from egad.seeds import generator
from egad.stage_settings import EvalSelection
from egad.stages.shards import join
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.objects import OBJECTS, SOLIDS

log = logging.getLogger(__name__)


def run(
    settings: EvalSelection, objects: Path, solids: list[Path], out: Path, threads: int
) -> None:
    """Choose one object a cell so that the set looks least alike.

    Args:
        settings: What this stage reads.
        objects: Table with the columns of `tables.objects.OBJECTS`.
        solids: The shards of the dataset, for the Reeb graphs.
        out: Table with the columns of `tables.evaluation.EVAL49`.
        threads: Objects compared at once; the result does not depend on it.
    """
    frame = parquet.read(objects, OBJECTS)
    packed = join(solids, SOLIDS, ["id"]).set_index("id")["graph"]
    graphs = [reeb.unpack(packed[object_id]) for object_id in frame["id"]]
    distances = 1 - similarity_matrix(graphs, settings.similarity.weight, threads)
    rng = generator(settings.seed, "select-eval")
    chosen = select(frame, distances, settings.select_eval, settings.space, rng)
    parquet.write(chosen, EVAL49, out)
    _log_distances(frame, chosen, distances, settings)
    if empty := empty_cells(chosen, settings.select_eval):
        log.info("%d cells that no object lies in: %s", len(empty), " ".join(empty))


def _log_distances(
    objects: pd.DataFrame,
    chosen: pd.DataFrame,
    distances: NDArray[np.float64],
    settings: EvalSelection,
) -> None:
    """Say how much less alike the chosen objects are than the best of 1000 random sets."""
    places = objects.reset_index().set_index("id").loc[chosen["id"], "index"].to_numpy()
    candidates = candidates_by_cell(objects, settings.select_eval, settings.space)
    rng = generator(settings.seed, "random-eval-sets")
    log.info(
        "%d objects, mean distance %.3f; best of 1000 random sets %.3f",
        len(chosen),
        mean_distance(places, distances),
        best_of_random(candidates, distances, rng),
    )
