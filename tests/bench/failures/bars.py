"""Bars of voxels, a detector that grasps only the thick ones, and an atlas of its failures."""

import math

import numpy as np
import pandas as pd
from partial_tables import fill_columns

from egad.bench.failures import Examination, FailureAtlas, FailureSearch
from egad.bench.failures.evidence import counts_of
from egad.bench.failures.finding import failure_parameters
from egad.bench.failures.models import scaled_to
from egad.detectors import Grasp, opened
from egad.evalset import PrintCheck
from egad.evolution import packed_surface
from egad.evolution.voxels import identity, pack
from egad.geometry.repair import repair_for_files
from egad.grippers import gripper
from egad.objects import load
from egad.tables.evolution import GENOME
from egad.tables.failures import EXAMINED, FAILURE_ATTEMPTS, FAILURES

RESOLUTION = 25
HIGH = 0.018  # metres, above all noise of the table
THICK = 0.036  # metres, between the shorter sides of the bars
# Name: sides across, voxels; verdict; cells of complexity and difficulty
BARS = {
    "thin": ((6, 6), "failure", (3, 5)),
    "flat": ((6, 8), "failure", (8, 5)),
    "liar": ((6, 7), "detector_succeeds", (4, 5)),  # no thicker than those
    "thick": ((12, 12), "detector_succeeds", (3, 6)),
    "broad": ((12, 15), "detector_succeeds", (7, 5)),
    "far": ((7, 8), "detector_succeeds", (15, 5)),
}

NONE = load()[[]]  # no objects besides those of the atlas


def thick_only(view, gripper, _):
    """Grasps the middle of a bar across its narrower side if it is thick, else beside it."""
    points = view.points()[view.heights() > HIGH]
    middle, top = points[:, :2].mean(axis=0), np.quantile(points[:, 2], 0.9)
    offsets = points[:, :2] - middle
    narrow = np.linalg.eigh(np.cov(offsets.T))[1][:, 0]
    thick = np.ptp(np.quantile(offsets @ narrow, (0.02, 0.98))) > THICK
    center = (*(middle if thick else middle + 0.1 * narrow), top - 0.012)
    return [Grasp(center, math.atan2(narrow[1], narrow[0]), gripper.opening, 0.012, 1.0)]


def voxels(sides):
    found = np.zeros((RESOLUTION,) * 3, dtype=bool)
    across, up = sides
    found[:, 2 : 2 + across, 3 : 3 + up] = True
    return found


def name_of(bar):
    return identity(voxels(BARS[bar][0]))


def settings():
    search = FailureSearch(
        approach="above", engines=("mujoco",), screen=3, choose=4, confirm=8, confidence=0.6
    )
    found = failure_parameters(gripper("panda"), search)
    return found.model_copy(update={"print_check": PrintCheck(wall=0.004)})


def mesh_of(bar):
    chosen = settings()
    packed = pack(voxels(BARS[bar][0]))
    mesh = repair_for_files(packed_surface(packed, chosen.breeding.shape)).mesh
    return scaled_to(mesh, chosen)


def examined(bar):
    """What a search would find of a bar."""
    with opened(thick_only, 60.0) as asked:
        return Examination(mesh_of(bar), name_of(bar), asked, settings()).run()


def atlas():
    """An atlas of the bars, with true attempts at those that can be told from the others."""
    genome = {name: load().archive.iloc[0][name] for name in GENOME.names}
    rows, tables = [], []
    for number, (bar, (sides, verdict, cell)) in enumerate(BARS.items()):
        attempts = pd.DataFrame(columns=FAILURE_ATTEMPTS.names)
        if bar != "far":
            found = examined(bar)
            assert bar == "liar" or found.verdict == verdict, bar
            attempts = found.attempts
        tables.append(attempts)
        rows.append(
            genome
            | counts_of(attempts)
            | {
                "id": name_of(bar),
                "verdict": verdict,
                "complexity": 1.0 + 0.1 * number,
                "graspability": 0.003,
                "complexity_cell": cell[0],
                "difficulty_cell": cell[1],
                "attempts": len(attempts),
                "voxels": pack(voxels(sides)),
            }
        )
    table = fill_columns(EXAMINED, rows)
    failures = table[table["verdict"] == "failure"]
    kept = [name for name in FAILURES.names if name in table]
    attempts = pd.concat(tables, ignore_index=True)
    return FailureAtlas(
        fill_columns(FAILURES, failures[kept]), table, attempts, settings=settings()
    )
