import builtins
import os
import subprocess
import sys
from contextlib import nullcontext
from unittest.mock import patch

# Tests run in a process a core: more threads would only wait for each other.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
os.environ["EGAD_CACHE_DIR"] = "off"  # what is tested is made

import numpy as np
import pandas as pd
import pytest
import trimesh
from compiled import checks_kernels
from forks import ADDRESS, forked, server

from egad._util import child_process
from egad._util.limited import limited
from egad.data import evaluation_set, released
from egad.detectors import DepthCamera, Intrinsics, camera_above
from egad.evolution import Shape, packed_surface
from egad.geometry.refinement import triangulation
from egad.geometry.repair import repair
from egad.geometry.scaling import rescale
from egad.sim import film
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE


def pytest_configure(config):
    """Let processes that share the tests share the one that forks."""
    if getattr(config.option, "numprocesses", None):
        os.environ[ADDRESS] = server()


def pytest_collection_modifyitems(items):
    """Begin with the cluster, which mostly waits: at the end a core would be idle."""
    items.sort(key=lambda item: item.get_closest_marker("slurm") is None)


@pytest.fixture(autouse=True, scope="module")
def _forked_workers(request):
    """Workers are forks, but where their own start is tested."""
    with nullcontext() if "util" in request.path.parts else forked():
        yield


@pytest.fixture
def started_reader():
    """Files are read in a started process: a fork leaves OpenUSD too little memory of its limit."""
    limited.close()
    with patch.object(child_process, "subprocess", subprocess):
        yield
    limited.close()


@pytest.fixture(scope="session")
def spiky_box():
    """Makes a box of random sides with random spikes, the same for the same number."""

    def make(number):
        rng = np.random.default_rng(number)
        mesh = trimesh.creation.box(extents=rng.uniform(0.2, 1, 3)).subdivide().subdivide()
        mesh.vertices[rng.random(len(mesh.vertices)) < 0.3] *= rng.uniform(0.6, 1.5)
        return mesh

    return make


@pytest.fixture
def lumpy():
    """A closed mesh without symmetries, 162 vertices."""
    mesh = trimesh.creation.icosphere(subdivisions=2)
    directions = np.random.default_rng(0).normal(size=(6, 3))
    mesh.vertices *= 1 + 0.1 * np.sin(2 * mesh.vertices @ directions.T).sum(axis=1, keepdims=True)
    return mesh


@pytest.fixture
def triangulate():
    return lambda mesh: triangulation(np.array(mesh.vertices), np.array(mesh.faces, np.int32))


@pytest.fixture(scope="session")
def look():
    """From a mesh that stands at (x, y), turned about the vertical, to a view of it."""

    def seen(mesh, x=0.0, y=0.0, turn=0.0, size=300):
        matrix = trimesh.transformations.rotation_matrix(turn, (0, 0, 1))
        matrix[:3, 3] = [x, y, -mesh.bounds[0, 2]]
        return DepthCamera(mesh).render(
            matrix, Intrinsics.spanning(size, size, 40.0), camera_above(0.6)
        )

    return seen


@pytest.fixture(scope="session")
def released_set():
    """The evaluation set of the released objects by label, scaled for an opening of 75 mm."""
    voxels = parquet.read(released(), ARCHIVE).set_index("id")["voxels"]
    chosen = pd.read_csv(evaluation_set()).itertuples()
    meshes = {row.label: repair(packed_surface(voxels[row.id], Shape())).mesh for row in chosen}
    return {label: rescale(mesh, "paper", 0.075, 0.8)[0] for label, mesh in meshes.items()}


def pytest_ignore_collect(collection_path):
    """Where every index of compiled code is checked, leave out what tests none of it."""
    checked = os.environ.get("NUMBA_BOUNDSCHECK", "0") != "0"
    is_test = collection_path.match("test_*.py")
    return True if checked and is_test and not checks_kernels(collection_path) else None


@pytest.fixture
def small_films(monkeypatch):
    """Films have a sixteenth of the pixels, where only what they are made of matters."""
    monkeypatch.setattr(film, "SIZE", tuple(side // 4 for side in film.SIZE))


@pytest.fixture
def without_usd(monkeypatch):
    """OpenUSD cannot be imported, as without its extra."""
    found = builtins.__import__

    def other(name, *more):
        if name.partition(".")[0] == "pxr":
            raise ModuleNotFoundError("No module named 'pxr'", name="pxr")
        return found(name, *more)

    monkeypatch.setattr(builtins, "__import__", other)
    for name in ("objects.usd", "grasps.simready"):
        monkeypatch.delitem(sys.modules, f"egad.exchange.{name}", raising=False)
