"""How fast the costly parts of the library are, in CPU time on one core: `make bench`.

Compiling is not counted. The objects are offspring of an archive that evolved for some steps.
"""

import os
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from egad.errors import RejectedError
from egad.evolution import (
    UNBOUND,
    Archive,
    EvolutionParameters,
    breed,
    evolve,
    express,
    packed_surface,
)
from egad.evolution.evaluation import GenomeVoxels
from egad.geometry.convex_parts import decompose, union_of_parts
from egad.grasps.parameters import LabelParameters
from egad.grasps.quality import ferrari_canny, wrenches
from egad.grasps.sampling import Labeller
from egad.measures.graspability import graspability, rough_graspability, spaced_graspability
from egad.measures.reeb import Forest, Neighborhood, similarities
from egad.measures.reeb import graph as reeb
from egad.tables import parquet
from egad.tables.evolution import EPOCH
from egad_workflow.settings import Settings, select

SETTINGS = Settings()
EVOLVE = select(SETTINGS, EvolutionParameters)
SECONDS = 3.0


def rate(what, unit, work, amount=1):
    """Repeat some work for a few seconds and print how much of it a second does."""
    work()
    start, rounds = time.process_time(), 0
    while time.process_time() - start < SECONDS:
        work()
        rounds += 1
    spent = time.process_time() - start
    print(f"\n{what}: {rounds * amount / spent:.3g} {unit}/s", end="")


@pytest.fixture(scope="module")
def elites():
    few = {"evolution": {"population": 20, "evaluations": 300}}
    archive = Archive(SETTINGS.space, SETTINGS.similarity)
    evolve(archive, select(Settings.model_validate(few), EvolutionParameters), 0, 0)
    return archive.elites


@pytest.fixture(scope="module")
def offspring(elites):
    return breed(elites, EVOLVE, 1, 0, 0)


@pytest.fixture(scope="module")
def solids(offspring):
    found = [express(each.genome, EVOLVE, UNBOUND) for each in offspring]
    return list({solid.id: solid for solid in found if isinstance(solid, GenomeVoxels)}.values())


@pytest.fixture(scope="module")
def meshes(solids):
    return [packed_surface(each.packed, EVOLVE.shape) for each in solids[:20]]


@pytest.fixture(scope="module")
def graphs(elites):
    """Reeb graphs: of the epoch archive that EGAD_ARCHIVE names, else of some offspring."""
    if "EGAD_ARCHIVE" in os.environ:
        packed = parquet.read(Path(os.environ["EGAD_ARCHIVE"]), EPOCH)["graph"]
        return [reeb.unpack(data) for data in packed]
    found = {}
    for step in range(30):
        for child in breed(elites, EVOLVE, 2, 0, step):
            solid = express(child.genome, EVOLVE, UNBOUND)
            if isinstance(solid, GenomeVoxels) and solid.id not in found:
                mesh = packed_surface(solid.packed, EVOLVE.shape)
                found[solid.id] = reeb.extract(mesh, SETTINGS.similarity)
    return list(found.values())


def cpu(work):
    """CPU seconds that some work takes."""
    start = time.process_time()
    work()
    return time.process_time() - start


def test_nearest_neighbors(graphs):
    """Exact neighbors of newcomers by bounds, beside comparing with everything."""
    weight, count = SETTINGS.similarity.weight, SETTINGS.space.neighbors
    archive, newcomers = graphs[:-100], graphs[-100:]
    neighborhood = Neighborhood(weight, count)
    neighborhood.add(archive)
    times = []
    for newcomer in newcomers:
        (index,) = neighborhood.add([newcomer])
        times.append(1000 * cpu(lambda index=index: neighborhood.nearest(index)))
        neighborhood.remove(index)
    forest = Forest(weight, [*archive, newcomers[0]])
    pairs = np.array([(len(archive), other) for other in range(len(archive))])
    similarities(forest, pairs[:2])
    exhaustive = 1000 * cpu(lambda: similarities(forest, pairs))
    print(
        f"\n{count} nearest of {len(archive)}: mean {np.mean(times[1:]):.1f} ms, "
        f"worst {max(times[1:]):.1f} ms, exhaustive search {exhaustive:.1f} ms",
        end="",
    )


def random_grasps(count):
    rng = np.random.default_rng(0)
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    normals = np.stack([-axes, axes], axis=1) + rng.normal(scale=0.1, size=(count, 2, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return np.stack([-axes, axes], axis=1) * 0.02, normals, axes


def test_grasp_qualities():
    points, normals, axes = random_grasps(1000)
    rate("quality", "grasps", lambda: ferrari_canny(points, normals, axes, np.zeros(3)), 1000)


def test_hulls_of_scipy():
    """What the quality of the same grasps costs by a whole convex hull of their 20 wrenches."""
    points, normals, axes = random_grasps(50)
    friction, torsion = np.full(len(axes), 0.5), np.pi * 0.005**2 * 100
    columns = wrenches(100 * points, normals, axes, friction, torsion, 8)

    def facets():
        for some in columns:
            (-ConvexHull(some).equations[:, -1]).min()

    rate("quality by scipy's hull", "grasps", facets, len(columns))


def test_graspability(meshes):
    ways = {
        "graspability from 100 grasps with spacing": partial(spaced_graspability, count=100),
        "first estimate of graspability": rough_graspability,
        "graspability, at most 16,384 candidates": partial(graspability, max_candidates=16384),
    }
    for name, way in ways.items():
        estimate = partial(way, settings=EVOLVE, rng=np.random.default_rng(0))
        rate(name, "objects", lambda estimate=estimate: list(map(estimate, meshes[:5])), 5)


def test_labels(meshes):
    """500 grasps per object with everything that is known about them, on default grippers."""
    wanted = Settings.model_validate({"grasp_label": {"grasps": 500}})
    for gripper in ("egad_75mm", "yumi"):
        settings = select(wanted, LabelParameters, gripper)
        side = 0.8 * settings.gripper.opening
        scaled = [mesh.copy().apply_scale(side / mesh.extents.min()) for mesh in meshes[:10]]
        found = sum(len(labelled(mesh, settings)) for mesh in scaled)
        rate(
            f"labels, {gripper}",
            "grasps",
            lambda settings=settings, scaled=scaled: [labelled(mesh, settings) for mesh in scaled],
            found,
        )


def labelled(mesh, settings):
    """The labelled grasps of a mesh, none if it has none."""
    try:
        return Labeller(settings)(mesh, mesh.center_mass, np.random.default_rng(0)).table
    except RejectedError:
        return []


def test_convex_parts(released_set):
    """Of the evaluation set of the released objects; the time of each and the volume error."""
    bound = SETTINGS.bundle
    found = {}
    for name, mesh in released_set.items():
        start = time.process_time()
        parts = decompose(mesh, bound.max_parts, bound.volume_error).parts
        spent = time.process_time() - start
        found[name] = spent, len(parts), union_of_parts(parts).volume() / mesh.volume - 1
    slowest = max(found, key=lambda name: found[name][0])
    spent, count, error = found[slowest]
    total = sum(each[0] for each in found.values())
    print(f"\nconvex parts: {total:.0f} s of CPU time for {len(found)} objects, ", end="")
    print(f"most for {slowest}: {spent:.1f} s, {count} parts, {100 * error:.1f} %", end="")
