"""The function that a Reeb graph is taken of: how far a point of a surface is from all the others.

mu(v) is the integral of the geodesic distance to v over the surface (Hilaga et al., "Topology
Matching for Fully Automatic Similarity Estimation of 3D Shapes", SIGGRAPH 2001), a sum over base
vertices that stand for parts of it.
"""

import numba
import numpy as np
from numpy.typing import NDArray

from egad.measures.geodesics import EdgeGraph, spread

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@numba.njit(cache=True)
def even_integral(
    graph: EdgeGraph, vertices: Floats, faces: Ints, areas: Floats, count: int
) -> Floats:
    """The integral from farthest-point bases, each of which stands for the vertices nearest to it.

    The first base is the vertex farthest from the centre of the surface, so neither the order of
    the vertices nor the place of the mesh matters; every other one is the vertex farthest from
    those before it. The choice of bases is ours: the paper leaves it open.

    Args:
        graph: Edges of the mesh.
        vertices: (n, 3).
        faces: (f, 3).
        areas: (f,) of the faces.
        count: Number of bases; fewer if no other vertex is left.

    Returns:
        (n,).
    """
    share = _shares(faces, areas, len(vertices))
    base = _farthest_from_centre(vertices, share)
    distances = np.full((min(count, len(vertices)), len(vertices)), np.inf)
    nearest = np.full(len(vertices), np.inf)
    owner = np.zeros(len(vertices), np.int64)
    used = 0
    while used < len(distances) and nearest[base] > 0:
        spread(graph, base, distances[used])
        base = _claim(distances[used], nearest, owner, used)
        used += 1
    weights = np.zeros(used)
    for vertex, area in enumerate(share):
        weights[owner[vertex]] += area
    result = np.zeros(len(vertices))
    for i in range(used):
        result += weights[i] * distances[i]
    return result


@numba.njit(cache=True)
def _shares(faces: Ints, areas: Floats, count: int) -> Floats:
    """Area of the surface that belongs to each vertex: a third of each of its faces."""
    share = np.zeros(count)
    for face, area in enumerate(areas):
        for vertex in faces[face]:
            share[vertex] += area / 3
    return share


@numba.njit(cache=True)
def _farthest_from_centre(vertices: Floats, share: Floats) -> int:
    squares = np.zeros(len(vertices))
    for k in range(3):
        centre = np.sum(vertices[:, k] * share) / np.sum(share)
        squares += (vertices[:, k] - centre) ** 2
    return int(np.argmax(squares))


@numba.njit(cache=True)
def _claim(distances: Floats, nearest: Floats, owner: NDArray[np.int64], number: int) -> int:
    """Give vertices that are nearer to a new base to it; returns the one farthest from all."""
    farthest = 0
    for vertex, distance in enumerate(distances):
        if distance < nearest[vertex]:
            owner[vertex], nearest[vertex] = number, distance
        if nearest[vertex] > nearest[farthest]:
            farthest = vertex
    return farthest


@numba.njit(cache=True)
def scan_integral(graph: EdgeGraph, faces: Ints, areas: Floats, radius: float) -> Floats:
    """The integral from the bases of the program that the published values come from.

    Vertices are walked in their order: one that is not covered yet becomes a base and covers all
    within the radius. It stands for all faces with a vertex that it is the first to cover, so
    faces between bases count several times, and another order of the vertices gives another mu.

    Args:
        graph: Edges of the mesh.
        faces: (f, 3).
        areas: (f,) of the faces.
        radius: Geodesic distance up to which a base covers.

    Returns:
        (n,).
    """
    count = len(graph.starts) - 1
    result, distances = np.zeros(count), np.empty(count)
    owner = np.full(count, -1)
    for base in range(count):
        if owner[base] < 0:
            distances[:] = np.inf
            spread(graph, base, distances)
            owner[(owner < 0) & (distances <= radius)] = base
            result += _patch(faces, areas, owner, base) * distances
    return result


@numba.njit(cache=True)
def _patch(faces: Ints, areas: Floats, owner: NDArray[np.int64], base: int) -> float:
    """Area of the faces that have a vertex of a base."""
    total = 0.0
    for face, area in enumerate(areas):
        for vertex in faces[face]:
            if owner[vertex] == base:
                total += area
                break
    return total
