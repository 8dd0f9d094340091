"""Closing small holes in a surface."""

import manifold3d
import numpy as np
import trimesh
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Loop = list[int]


def open_edges(faces: Ints) -> Ints:
    """Edges (a, b) that a missing triangle would have, (n, 2): b to a has one face, a to b none."""
    there = np.asarray(faces)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    wanted = there[:, ::-1]
    keys, count = np.unique(np.vstack([there, wanted]), axis=0, return_inverse=True)
    surplus = np.bincount(count[: len(there)], minlength=len(keys))
    surplus -= np.bincount(count[len(there) :], minlength=len(keys))
    missing: Ints = np.repeat(keys, np.maximum(-surplus, 0), axis=0)
    return missing


def close_holes(mesh: trimesh.Trimesh, largest: float) -> trimesh.Trimesh | None:
    """Fill the holes of a surface: each rim is triangulated as seen along its mean normal (ours).

    Args:
        mesh: Consistently wound; not changed.
        largest: Most area of all patches together, as a part of the area of the surface.

    Returns:
        The closed surface; None if open edges form no loops, or the holes are too large.
    """
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    loops = simple_loops(open_edges(faces))
    if loops is None:
        return None
    patches = [np.asarray(loop)[_triangles(vertices[loop])] for loop in loops]
    closed = trimesh.Trimesh(vertices, np.vstack([faces, *patches]), process=False)
    return closed if closed.area <= (1 + largest) * mesh.area else None


def simple_loops(edges: Ints) -> list[Loop] | None:
    """Loops that use every directed edge once and visit no vertex twice; None if there are none."""
    after: dict[int, list[int]] = {}
    for start, end in edges.tolist():
        after.setdefault(start, []).append(end)
    loops: list[Loop] = []
    for start, ends in after.items():
        path = [start]
        while ends or len(path) > 1:
            if not after.get(path[-1]):
                return None
            vertex = after[path[-1]].pop()
            if vertex in path:
                cut = path.index(vertex)
                loops.append(path[cut:])
                del path[cut + 1 :]
            else:
                path.append(vertex)
    return loops


def _triangles(rim: Floats) -> Ints:
    """Triangles between the points of a rim (n, 3), wound as the rim is; (n - 2, 3)."""
    centred = rim - rim.mean(axis=0)
    normal = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    if not normal.any():
        return np.empty((0, 3), dtype=np.int64)
    to_plane = trimesh.geometry.align_vectors(normal, [0, 0, 1])
    seen = np.ascontiguousarray((centred @ to_plane[:3, :3].T)[:, :2])
    return np.asarray(manifold3d.triangulate([seen])).astype(np.int64).reshape(-1, 3)
