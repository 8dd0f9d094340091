"""Whether an object can be printed as it is (ours)."""

import numpy as np
import trimesh

from egad.evalset.thickness import thinness
from egad.settings import PrintCheck

STUB = 0.5  # of the thinnest wall: thin parts that stand out less are no walls


def print_problems(mesh: trimesh.Trimesh, check: PrintCheck) -> list[str]:
    """What keeps an object from being printed, at the size that it has.

    It must be closed, one body without a trapped void, and nowhere thinner than the nozzle
    allows: a ball as wide as the thinnest wall, rolled inside, must come close to all of the
    surface, and get from everywhere to everywhere. Edges and tips may become blunter as far as
    the settings say; where both sides are parallel within 30 degrees, half a wall is the limit.

    Args:
        mesh: Metres, scaled as it will be printed.
        check: Thinnest wall, and what counts as an edge or a tip.

    Returns:
        A few words for each problem; nothing if it can be printed.
    """
    if not mesh.is_watertight or not mesh.is_winding_consistent:
        return ["not closed"]
    volumes = shell_volumes(mesh)
    if sum(volumes) <= 0:
        return ["wound inwards"]
    problems = []
    if (bodies := sum(volume > 0 for volume in volumes)) != 1:
        problems.append(f"{bodies} bodies")
    if voids := sum(volume <= 0 for volume in volumes):
        problems.append(f"{voids} trapped void{'s' if voids > 1 else ''}")
    found = thinness(mesh, check.wall)
    wall = f"{1000 * check.wall:g} mm"
    if found.edge > check.blunting or found.wall > STUB * check.wall:
        problems.append(f"walls thinner than {wall}")
    elif found.part > check.blunting and not problems:  # the wall of a void is a part of its own
        problems.append(f"parts joined by less than {wall}")
    return problems


def shell_volumes(mesh: trimesh.Trimesh) -> list[float]:
    """Volume within each closed shell, m3; that of a shell around a void is negative."""
    shells = trimesh.graph.connected_components(
        mesh.face_adjacency, nodes=np.arange(len(mesh.faces)), min_len=1
    )
    corners = np.asarray(mesh.triangles) - np.asarray(mesh.bounds).mean(axis=0)
    parts = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    return [float(parts[shell].sum()) for shell in shells]
