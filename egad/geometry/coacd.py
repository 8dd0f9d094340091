"""Convex parts by CoACD, the alternative to our own decomposition."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.arrays import Floats
from egad._util.child_process import Worker, WorkerDiedError, WorkerTimeoutError
from egad._util.extras import check_installed
from egad.errors import RejectedError
from egad.geometry.hull_vertices import fewer_vertices
from egad.geometry.hulls import hull_mesh, hull_of

TIME_LIMIT = 1800  # seconds; it takes minutes at most

Task = tuple[Floats, NDArray[np.int64], float, int]


def coacd_parts(
    mesh: trimesh.Trimesh, threshold: float, max_parts: int, max_vertices: int
) -> list[trimesh.Trimesh]:
    """Convex hulls that together approximate a solid, wound outwards, by CoACD with seed 0.

    It runs in a separate process because it sometimes aborts its process. Corners that matter least
    are left out. Raises `UserError` if `coacd` is not installed or its process was killed,
    `RejectedError` if it fails. Source: Wei et al., Approximate Convex Decomposition for 3D Meshes
    with Collision-Aware Concavity and Tree Search, 2022.
    """
    check_installed("coacd", "bundle.method: coacd")
    task = (np.array(mesh.vertices), np.array(mesh.faces), threshold, max_parts)
    try:
        with Worker(_coacd, TIME_LIMIT, name="CoACD") as run:
            parts: list[Floats] = run(task)
    except (WorkerDiedError, WorkerTimeoutError) as error:
        raise RejectedError(str(error)) from error
    hulls = [hull for hull in map(hull_of, parts) if hull.volume > 0]
    solid = [hull_mesh(fewer_vertices(hull, max_vertices, 0.0, 0.0)[0]) for hull in hulls]
    if not solid:
        raise RejectedError("CoACD found no part with a volume")
    return solid


@contextmanager
def _coacd() -> Iterator[Callable[[Task], list[Floats]]]:
    """Run CoACD in this process and discard its output: it prints a lot."""
    import coacd  # noqa: PLC0415 (an extra)

    silence = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(silence, stream)
    coacd.set_log_level("error")

    def run(task: Task) -> list[Floats]:
        vertices, faces, threshold, max_parts = task
        mesh = coacd.Mesh(vertices, faces)
        options = {"threshold": threshold, "max_convex_hull": max_parts}
        try:
            found = coacd.run_coacd(mesh, preprocess_mode="off", seed=0, **options)
        except Exception as error:
            raise RejectedError(f"CoACD failed: {error}") from error
        return [np.asarray(vertices) for vertices, _ in found]

    yield run
