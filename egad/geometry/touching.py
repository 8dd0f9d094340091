"""Surfaces that touch themselves: which faces at an edge or a vertex belong together."""

import numpy as np
import trimesh
from trimesh.graph import connected_component_labels

from egad._util.arrays import Floats, Ints
from egad.geometry.checks import is_closed

TURN = 1 << 20  # steps around an edge: faces in the same step are in one plane
AFTER = np.array([1, 1, -2])  # from a corner of a face to the next


def wedge_pairs(vertices: Floats, faces: Ints) -> Ints:
    """Pairs (k, 2) of half-edges, 3 face + corner, with one wedge of solid between their faces.

    Only edges with more than two faces have them, unless solids overlap there.
    """
    starts, ends = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    keys = np.minimum(starts, ends) * len(vertices) + np.maximum(starts, ends)
    _, edge, counts = np.unique(keys, return_inverse=True, return_counts=True)
    halves = np.flatnonzero(counts[edge] > 2)
    edge, outward = edge[halves], (starts < ends)[halves]  # the normal points out of the wedge
    low = vertices[np.minimum(starts, ends)[halves]]
    axes = trimesh.unitize(vertices[np.maximum(starts, ends)[halves]] - low)
    tips = np.roll(faces, 1, axis=1).ravel()[halves]
    across = np.cross(axes, np.eye(3)[np.abs(axes).argmin(axis=1)])
    arms, upright = vertices[tips] - low, np.cross(axes, across)
    angles = np.arctan2(np.einsum("ij,ij->i", arms, upright), np.einsum("ij,ij->i", arms, across))
    turns = np.round(angles / (2 * np.pi) * TURN).astype(np.int64) % TURN
    order = np.lexsort((~outward, turns, edge))  # one wedge ends before another begins
    edge, outward, halves = edge[order], outward[order], halves[order]
    following = np.arange(1, len(edge) + 1)
    last = np.flatnonzero(np.diff(edge, append=-1))
    following[last] = np.searchsorted(edge, edge[last])
    mixed = np.isin(edge, edge[outward == outward[following]])
    begins = np.flatnonzero(~outward & ~mixed)
    return np.column_stack([halves[begins], halves[following[begins]]])


def separated(vertices: Floats, faces: Ints, divide: bool = True) -> tuple[Floats, Ints]:
    """A closed surface with vertices repeated where it touches itself: each edge has two faces."""
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    if not (_has_doubled_edges(vertices, faces) and is_closed(mesh)):
        return vertices, faces
    keys = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    _, edge, counts = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    order, wedges = np.argsort(edge, kind="stable"), wedge_pairs(vertices, faces)
    if 2 * len(wedges) != np.count_nonzero(counts[edge] > 2):
        return vertices, faces
    pairs = np.vstack([order[counts[edge[order]] == 2].reshape(-1, 2), wedges])
    one, other = pairs.T
    links = np.vstack([_across(one, other), _across(other, one)])
    fans = connected_component_labels(links, node_count=faces.size)
    first = np.unique(fans, return_index=True)[1]
    split = vertices[faces.ravel()[first]], fans.reshape(-1, 3).astype(np.int64)
    if divide and _has_doubled_edges(*split):
        finer, quarters = trimesh.remesh.subdivide(vertices, faces)[:2]
        return separated(finer, quarters, divide=False)
    return split


def _has_doubled_edges(vertices: Floats, faces: Ints) -> bool:
    """Whether several faces pass the same edge in the same direction."""
    edges = np.sort((faces * len(vertices) + np.roll(faces, -1, axis=1)).ravel())
    return bool((edges[1:] == edges[:-1]).any())


def _across(one: Ints, other: Ints) -> Ints:
    """Corners where half-edges begin, and where the opposite ones end."""
    return np.column_stack([one, other + AFTER[other % 3]])
