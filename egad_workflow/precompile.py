"""Compile the kernels of the pipeline on a small object: `python -m egad_workflow.precompile`.

Jobs that run in parallel would each compile the kernels that they share. A kernel that is not
compiled here is compiled at its first use.
"""

import sys
from operator import call

import numpy as np
import trimesh

from egad._util.kernel_cache import compiled_marker
from egad._util.workers import workers
from egad.detectors import Intrinsics, View, camera_above, fuse
from egad.evolution import Shape
from egad.evolution.growth import surface
from egad.geometry import decompose
from egad.geometry.repair import repair
from egad.grasps import LabelParameters
from egad.grasps.sampling import Labeller
from egad.measures import MeasureParameters, rough_graspability
from egad.measures.complexity import complexity
from egad.measures.reeb import Forest, diversities, extract, similarities
from egad.random import generator
from egad_workflow.settings import Settings, select


def compile_grasps() -> None:
    """Sampling, quality and collisions of grasps, graspability; triangles that cross; parts."""
    mesh, rng = repair(_example()).mesh, generator(0, "precompile")
    labels = select(Settings(), LabelParameters)
    Labeller(labels)(mesh, mesh.center_mass, rng)
    rough_graspability(mesh, select(Settings(), MeasureParameters), rng)
    decompose(mesh, 64, 0.5)


def compile_measures() -> None:
    """Complexity, Reeb graphs and their matching."""
    mesh, settings = _example(), Settings()
    complexity(mesh, settings.complexity.bins)
    graphs, weight = [extract(mesh, settings.similarity)] * 2, settings.similarity.weight
    diversities(graphs, weight, 1)
    similarities(Forest(weight, graphs), np.array([[0, 1]]))


def compile_fusion() -> None:
    """Fusion of depth images."""
    view = View(np.ones((2, 2), np.float32), Intrinsics.spanning(2, 2, 60.0), camera_above(1.0))
    fuse([view], np.zeros(3), 1.0, 2)


def _example() -> trimesh.Trimesh:
    """A small object like those of evolution."""
    voxels = np.zeros((25, 25, 25), bool)
    voxels[8:16, 10:14, 4:20] = voxels[8:12, 4:20, 4:8] = True
    return surface(voxels, Shape())


def compile_kernels() -> None:
    """Compile all kernels in two processes, unless that was done before."""
    if compiled_marker().exists():
        return
    try:
        with workers(2) as mapper:
            list(mapper(call, (compile_grasps, compile_measures, compile_fusion)))
    except Exception as error:
        print(
            f"Compilation failed; kernels will be compiled at their first use: {error}",
            file=sys.stderr,
            flush=True,
        )
    else:
        compiled_marker().touch()


if __name__ == "__main__":
    compile_kernels()
