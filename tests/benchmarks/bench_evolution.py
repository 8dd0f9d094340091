"""What one evaluation of evolution costs, step by step, in CPU time on one core: `make bench`.

The mean is over all offspring, those without a solid and those known already included. The archive
is grown here for a few steps, or read from the epoch archive that `EGAD_ARCHIVE` names. Its
diversities are computed first, as they are known but for the first steps of an epoch.
"""

import os
import time
from collections import Counter
from pathlib import Path

import pytest
from timing import timed

from egad.evolution import (
    Archive,
    EvolutionParameters,
    archive,
    constraints,
    elites_of,
    evaluation,
    island,
    surface,
)
from egad.evolution import query as cppn
from egad.measures import graspability
from egad.measures import measure as coordinates
from egad.measures.reeb import graph as reeb
from egad.measures.reeb import neighbors
from egad.tables import parquet
from egad.tables.evolution import EPOCH
from egad_workflow.settings import Settings, select

STEPS = {
    "reproduction": (island, "breed"),
    "network query": (cppn, "query"),
    "voxels": (constraints, "solid"),
    "meshing": (surface, "marching_cubes"),
    "smoothing and scaling": (evaluation, "packed_surface"),
    "ray caster": (graspability, "RayCaster"),
    "grasp sampling": (graspability, "valid_contacts"),
    "grasp quality": (graspability, "ferrari_canny"),
    "bound on quality": (graspability, "quality_bound"),
    "rest of first estimate": (evaluation, "rough_graspability"),
    "rest of refinement": (island, "refine"),
    "complexity": (coordinates, "complexity"),
    "Reeb graph": (reeb, "extract"),
    "neighbors": (neighbors.Neighborhood, "_look_up"),
    "adding new shapes to the index": (neighbors.Neighborhood, "add"),
    "rest of insertion": (archive.Archive, "add"),
    "history": (island, "snapshot"),
}


def settings(steps):
    evolution = {"population": 100, "evaluations": 100 * steps}
    return select(Settings.model_validate({"evolution": evolution}), EvolutionParameters)


@pytest.fixture(scope="module")
def elites():
    path = os.environ.get("EGAD_ARCHIVE")
    grown = Archive(settings(1).space, settings(1).similarity)
    if path:
        grown.add(elites_of(parquet.read(Path(path), EPOCH)))
    else:
        island.evolve(grown, settings(5), 0, 0)
    return grown


def test_an_evaluation(elites, monkeypatch):
    island.evolve(elites, settings(1), 1000, 0)  # compiles
    elites.to_frame()
    size, spent, running = len(elites), Counter(), []
    for step, (owner, name) in STEPS.items():
        monkeypatch.setattr(owner, name, timed(getattr(owner, name), step, spent, running))
    start = time.process_time()
    done = island.evolve(elites, settings(4), 1001, 0)
    total = time.process_time() - start
    spent["the rest"] = total - sum(spent.values())
    count, refined = done.outcomes.total(), done.history["refined"].sum()
    print(f"\n{size} elites; of {count} offspring {dict(done.outcomes)}, {refined} refined")
    for step, seconds in spent.most_common():
        print(f"{1000 * seconds / count:8.2f} ms  {step}")
    print(f"{1000 * total / count:8.2f} ms  an evaluation")
