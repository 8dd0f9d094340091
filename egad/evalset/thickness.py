"""How thin a solid is: where no ball of a given diameter fits inside (ours)."""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.sparse import coo_array, csgraph
from scipy.spatial import cKDTree

from egad.evalset.samples import Samples, spread

Floats = NDArray[np.float64]

SPACING = 0.8  # of the diameter: longest side of the pieces that triangles are cut into
NEAREST = 6  # samples whose triangles may be the nearest one
SLACK = 0.95  # of the radius: a ball that touches one facet of a curve cuts into the next
CRUMB = 0.01  # of the samples: fewer are no piece of their own


class Thinness(NamedTuple):
    """What a ball of a given diameter, rolled inside a solid, cannot reach.

    Attributes:
        reach: How far the surface lies from what the ball can reach, at most; inf if it fits
            nowhere. A flat face has 0, a right-angled edge 0.21 diameters, a wall that is thinner
            than the ball half its width or more.
        pieces: How many bodies are left of the solid without what is too thin.
    """

    reach: float
    pieces: int


def thinness(mesh: trimesh.Trimesh, diameter: float) -> Thinness:
    """Roll a ball inside a solid: the morphological opening, measured on the surface.

    A point of the surface is reached if the ball that touches it from within meets no other part
    of the surface. What the ball reaches is the union of these balls.

    Args:
        mesh: A closed surface, wound outwards.
        diameter: Of the ball, in the unit of the mesh.
    """
    radius = diameter / (1 + SLACK)  # so that a plate passes if it is as thick as the diameter
    samples = spread(mesh, SPACING * diameter)
    centres = samples.points - radius * samples.normals
    reached = _distances(mesh, samples, centres) >= SLACK * radius
    if not reached.any():
        return Thinness(np.inf, 0)
    lost, balls = samples.points[~reached], centres[reached]
    away = cKDTree(balls).query(lost)[0] if len(lost) else np.zeros(1)
    return Thinness(max(0.0, float(np.max(away)) - radius), _pieces(balls, diameter))


def thinnest(
    mesh: trimesh.Trimesh, sharpness: float, bounds: tuple[float, float], steps: int
) -> float:
    """The largest ball that a solid is thick enough for, by bisection: its wall thickness.

    Args:
        mesh: A closed surface, wound outwards.
        sharpness: The largest reach, in diameters, that is no wall but an edge or a tip.
        bounds: Diameters to look between.
        steps: Halvings.

    Returns:
        A diameter that passes, or the lower bound.
    """
    low, high = bounds
    for _ in range(steps):
        middle = (low * high) ** 0.5
        found = thinness(mesh, middle)
        if found.reach <= sharpness * middle and found.pieces == 1:
            low = middle
        else:
            high = middle
    return low


def _distances(mesh: trimesh.Trimesh, samples: Samples, points: Floats) -> Floats:
    """Distances of points to the surface, (n,): to the triangles of the nearest samples."""
    nearest = min(NEAREST, len(samples.points))
    _, found = cKDTree(samples.points).query(points, k=nearest)
    faces = samples.faces[np.reshape(found, (-1, nearest))]
    each = np.repeat(points, nearest, axis=0)
    closest = trimesh.triangles.closest_point(np.asarray(mesh.triangles)[faces.ravel()], each)
    distances: Floats = np.linalg.norm(each - closest, axis=1).reshape(-1, nearest).min(axis=1)
    return distances


def _pieces(balls: Floats, diameter: float) -> int:
    """Bodies that balls make up: those that lie about a diameter apart hang together."""
    cells, count = np.unique(np.floor(balls / diameter), axis=0, return_counts=True)
    links = cKDTree(cells).query_pairs(1.0, p=np.inf, output_type="ndarray")
    size = (len(cells), len(cells))
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=size)
    _, piece = csgraph.connected_components(graph, directed=False)
    return int((np.bincount(piece, weights=count) > CRUMB * len(balls)).sum())
