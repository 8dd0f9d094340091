"""How many objects lie where the map says: `certainty.py SOURCE... [MAPS.svg]`.

SOURCE is `released`, an archive, or the folder of a dataset, as for `egad.load`; NAME=SOURCE names
it. It must have the default gripper, metric and cells. Every object gets an independent estimate of
its graspability, from grasps that neither evolution nor the pipeline has seen: candidates are
doubled until its cell is certain with a probability of 99.9 %, at most 32,768. The maps show the
cells as labelled and as measured again.
"""

import sys
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh

import egad
from egad._util.files import write_text
from egad._util.progress import progress
from egad._util.workers import workers
from egad.grippers import gripper
from egad.measures import MeasureSpace, coverage, default_measures, difficulty_cells
from egad.measures.graspability import graspability
from egad.random import generator
from egad.report.comparison import dataset_maps

BUDGET, CERTAIN = 32_768, 0.999
SPACE = MeasureSpace(confidence=CERTAIN)


def independent(mesh: trimesh.Trimesh, name: str) -> float:
    """The graspability of an object, from grasps that no selection has used.

    Args:
        mesh: Closed, in any unit.
        name: Its id, which seeds the grasps.
    """
    settings = default_measures(gripper("yumi"), 0).model_copy(update={"space": SPACE})
    return graspability(mesh, settings, BUDGET, generator(0, "independent", name)).value


def main(arguments: list[str]) -> None:
    """Print a row for each source, and draw the maps if a file is given."""
    print("| source | objects | in their cell | within one | coverage | corrected |")
    print("| --- " * 6 + "|")
    maps: dict[str, pd.DataFrame] = {}
    for argument in (each for each in arguments if not each.endswith(".svg")):
        name, _, source = argument.rpartition("=")
        name = name or source
        table = egad.load(source).table
        with workers(2) as mapper:
            work = mapper(partial(_named, source), table["label"])
            found = list(progress(work, "measuring again", len(table)))
        again = table.assign(difficulty_cell=difficulty_cells(np.array(found), SPACE))
        print(f"| {name} | {len(table)} | {' | '.join(_agreement(table, again))} |", flush=True)
        maps |= {f"{name}, as labelled": table, f"{name}, measured again": again}
    for drawing in (each for each in arguments if each.endswith(".svg")):
        write_text(Path(drawing), dataset_maps(maps, SPACE))


_loaded = cache(egad.load)  # once a process


def _named(source: str, label: str) -> float:
    each = _loaded(source)[label]
    return independent(each.mesh, each.id)


def _agreement(table: pd.DataFrame, again: pd.DataFrame) -> Iterator[str]:
    """Shares of objects in their cell and within one; coverage as labelled and as remeasured."""
    off = np.abs(again["difficulty_cell"] - table["difficulty_cell"])
    yield from (f"{100 * np.mean(off <= most):.1f} %" for most in (0, 1))
    yield from (f"{coverage(each, SPACE):.3f}" for each in (table, again))


if __name__ == "__main__":
    main(sys.argv[1:])
