"""Convex parts by CoACD, the other choice beside our own cutting."""

import importlib.util
import io
import subprocess
import sys

import numpy as np
import trimesh

from egad._util.workers import check_not_killed
from egad.errors import RejectedError, UserError
from egad.geometry.hulls import hull_mesh, hull_of

TIME_LIMIT = 1800  # seconds; it takes minutes at most
CHILD = "egad.geometry.coacd_child"


def coacd_parts(mesh: trimesh.Trimesh, threshold: float, max_parts: int) -> list[trimesh.Trimesh]:
    """Convex hulls that together stand for a solid, by CoACD with its seed 0.

    It runs in a process of its own, which it is known to abort at times.

    Args:
        mesh: A closed surface wound outwards: inside out, CoACD loses most of the volume.
        threshold: Concavity that a part may have, CoACD's measure.
        max_parts: Most hulls.

    Returns:
        Convex meshes with outward normals, at least one.

    Raises:
        UserError: The package `coacd` is not installed, or its process was killed.
        RejectedError: CoACD fails.

    Source: Wei et al., Approximate Convex Decomposition for 3D Meshes with Collision-Aware
    Concavity and Tree Search, 2022.
    """
    if importlib.util.find_spec("coacd") is None:
        raise UserError("bundle.method is coacd, which is not installed: pip install 'egad[coacd]'")
    sent = _packed(vertices=mesh.vertices, faces=mesh.faces)
    command = [sys.executable, "-m", CHILD, repr(float(threshold)), str(max_parts)]
    try:
        done = subprocess.run(  # noqa: S603
            command, input=sent, capture_output=True, timeout=TIME_LIMIT, check=True
        )
    except subprocess.CalledProcessError as error:
        check_not_killed(error.returncode, "CoACD")
        raise RejectedError(f"CoACD ended with status {error.returncode}") from error
    except subprocess.TimeoutExpired as error:
        raise RejectedError(f"CoACD took more than {TIME_LIMIT} s") from error
    with np.load(io.BytesIO(done.stdout)) as parts:
        hulls = [hull_of(parts[f"part{number}"]) for number in range(len(parts))]
    solid = [hull_mesh(hull) for hull in hulls if hull.volume > 0]
    if not solid:
        raise RejectedError("CoACD found no part with a volume")
    return solid


def _packed(**arrays: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)  # type: ignore[arg-type]
    return buffer.getvalue()
