"""How fast the costly parts of the library are, in CPU time on one core: `make bench`.

Compiling is not counted. The objects are offspring of an archive that evolved for some steps.
"""

import time

import numpy as np
import pytest

from egad.evolution.archive import Archive
from egad.evolution.evaluation import express, measure
from egad.evolution.island import evolve
from egad.evolution.reproduction import breed
from egad.grasps.labels import label
from egad.grasps.quality import ferrari_canny
from egad.measures import reeb
from egad.measures.similarity import similarity_matrix
from egad.settings import Settings
from egad.shapes import cppn
from egad.shapes.surface import packed_surface
from egad.stage_settings import Evolve, GraspLabels, select

SETTINGS = Settings()
EVOLVE = select(SETTINGS, Evolve)
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
    few = {"evolution": {"population": 20, "steps_per_epoch": 15}}
    archive = Archive(SETTINGS.space, SETTINGS.similarity)
    evolve(archive, select(Settings.model_validate(few), Evolve), 0, 0)
    return archive.elites


@pytest.fixture(scope="module")
def offspring(elites):
    return breed(elites, EVOLVE, 1, 0, 0)


@pytest.fixture(scope="module")
def solids(offspring):
    found = [express(each.genome, EVOLVE) for each in offspring]
    return list({solid.id: solid for solid in found if solid is not None}.values())


@pytest.fixture(scope="module")
def meshes(solids):
    return [packed_surface(each.packed, EVOLVE.shape) for each in solids[:20]]


def test_network_queries(offspring):
    resolution = EVOLVE.shape.resolution

    def query():
        for each in offspring:
            cppn.query(each.genome, resolution)

    rate("network queries", "genomes", query, len(offspring))


def test_breeding():
    rate("breeding", "children", lambda: breed([], EVOLVE, 0, 0, 1), EVOLVE.evolution.population)


def test_evaluations(solids):
    def evaluate():
        for solid in solids[:20]:
            measure(solid, EVOLVE)

    rate("measuring", "objects", evaluate, len(solids[:20]))


def test_reeb_graphs(meshes):
    def extract():
        for mesh in meshes:
            reeb.extract(mesh, SETTINGS.similarity)

    rate("Reeb graphs", "objects", extract, len(meshes))


def test_similarities(meshes):
    graphs = [reeb.extract(mesh, SETTINGS.similarity) for mesh in meshes]
    pairs = len(graphs) * (len(graphs) - 1) // 2
    weight = SETTINGS.similarity.weight
    rate("similarity", "pairs", lambda: similarity_matrix(graphs, weight), pairs)


def test_grasp_qualities():
    rng = np.random.default_rng(0)
    count = 1000
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    normals = np.stack([-axes, axes], axis=1) + rng.normal(scale=0.1, size=(count, 2, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    points = np.stack([-axes, axes], axis=1) * 0.02
    rate("quality", "grasps", lambda: ferrari_canny(points, normals, axes, np.zeros(3)), count)


def test_labels(meshes):
    settings = select(SETTINGS, GraspLabels)
    mesh = meshes[0].copy()
    mesh.apply_scale(0.04 / mesh.extents.min())
    rng = np.random.default_rng(0)
    rate("grasp labels", "objects", lambda: label(mesh, mesh.center_mass, settings, rng))
