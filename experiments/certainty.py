"""How many objects lie where the map says: `python experiments/certainty.py SOURCE...`.

SOURCE is `released`, an archive, or the folder of a dataset, as for `egad.load`. Every object gets
an independent estimate of its difficulty, from grasps that neither evolution nor the pipeline has
seen: candidates are doubled until its cell is certain with a probability of 99.9 %, at most 32,768.
"""

import sys
from functools import cache, partial

import numpy as np
import pandas as pd
import trimesh

import egad
from egad._util.progress import progress
from egad._util.workers import workers
from egad.grasps import gripper
from egad.measures import Space, coverage, default_measures, difficulty_cells
from egad.measures.difficulty import difficulty
from egad.random import generator

BUDGET, CERTAIN = 32_768, 0.999
SPACE = Space(confidence=CERTAIN)


def independent(mesh: trimesh.Trimesh, name: str) -> float:
    """The difficulty of an object by grasps that nothing was selected by.

    Args:
        mesh: Closed, in any unit.
        name: Its id: names the grasps.
    """
    settings = default_measures(gripper("yumi"), 0).model_copy(update={"space": SPACE})
    return difficulty(mesh, settings, BUDGET, generator(0, "independent", name)).value


def main(sources: list[str]) -> None:
    """Print a row for each source."""
    print("| source | objects | in their cell | within one | coverage | corrected |")
    print("| --- " * 6 + "|")
    for source in sources:
        objects = egad.load(source)
        table = objects.table
        with workers(2) as mapper:
            work = mapper(partial(_named, source), table["label"])
            found = list(progress(work, "measuring again", len(table)))
        cells = difficulty_cells(np.array(found), SPACE)
        off = np.abs(cells - table["difficulty_cell"].to_numpy())
        parts = (f"{100 * np.mean(off <= most):.1f} %" for most in (0, 1))
        print(f"| {source} | {len(table)} | {' | '.join(parts)} | {_coverages(table, cells)} |")


_loaded = cache(egad.load)  # once a process


def _named(source: str, label: str) -> float:
    each = _loaded(source)[label]
    return independent(each.mesh, each.id)


def _coverages(table: pd.DataFrame, cells: np.ndarray) -> str:
    both = table, table.assign(difficulty_cell=cells)
    return " | ".join(f"{coverage(each, SPACE):.3f}" for each in both)


if __name__ == "__main__":
    main(sys.argv[1:])
