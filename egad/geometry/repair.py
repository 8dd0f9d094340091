"""Repair: any triangle mesh to one closed surface that bounds a solid, or the reason why not."""

from typing import NamedTuple

import manifold3d
import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.sparse import coo_array, csgraph
from scipy.spatial import cKDTree

from egad.errors import RejectedError
from egad.geometry.manifold import Solid, is_solid, to_mesh, to_solid, union
from egad.geometry.self_intersections import DEPTH, crossings, untangle

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
    centerd = rim - rim.mean(axis=0)
    normal = np.cross(centerd, np.roll(centerd, -1, axis=0)).sum(axis=0)
    if not normal.any():
        return np.empty((0, 3), dtype=np.int64)
    to_plane = trimesh.geometry.align_vectors(normal, [0, 0, 1])
    seen = np.ascontiguousarray((centerd @ to_plane[:3, :3].T)[:, :2])
    return np.asarray(manifold3d.triangulate([seen])).astype(np.int64).reshape(-1, 3)


CRACK = 1e-4  # of the longest side: open edges that are this close belong together
LARGEST_HOLE = 0.1  # of the area of a shell; a larger one may be the mouth of a cup
DEBRIS = 0.1  # of the area of all shells: open shells that together have less are dropped
FLAT = 1e-6  # volume / longest side cubed: thinner than this bounds nothing
THIN = f"no volume, or less than {FLAT:g} of the cube of its longest side"


class Repaired(NamedTuple):
    """A closed surface, and whether more than merging vertices was needed."""

    mesh: trimesh.Trimesh
    changed: bool


def repair(mesh: trimesh.Trimesh) -> Repaired:
    """The outer surface of the largest solid part of a mesh (ours, on manifold3d).

    A mesh that already is one closed surface without crossings comes back with its triangles as
    they were. Otherwise: cracks are welded; faces without area and doubled faces removed; every
    shell is wound outwards and its small holes closed; the union of the shells is taken, in
    which overlaps and the walls of trapped voids vanish; its largest part by volume is kept, and
    places where that passes through itself are cut out and rebuilt.

    Args:
        mesh: In any unit; not changed.

    Returns:
        The surface, wound outwards, every edge with exactly two faces.

    Raises:
        RejectedError: The mesh is not finite, has no area or no volume, holes too large to close,
            or faces that no solid can have.
    """
    check_surface(mesh)
    merged = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    merged.merge_vertices(merge_tex=True, merge_norm=True)
    if _is_sound(merged):
        return Repaired(merged, changed=False)
    solid = _largest(union(_solids(_cleaned(_welded(merged)))))
    solid = _largest(untangle(solid))
    return Repaired(to_mesh(solid), changed=True)


def check_surface(mesh: trimesh.Trimesh) -> None:
    """Make sure that there is a surface at all.

    Raises:
        RejectedError: No faces, coordinates that are not finite, or no area.
    """
    if len(mesh.faces) == 0:
        raise RejectedError("no faces")
    if not np.isfinite(mesh.vertices).all():
        raise RejectedError("coordinates that are not finite")
    if not mesh.area > 0:
        raise RejectedError("no area")


def _is_sound(mesh: trimesh.Trimesh) -> bool:
    """Whether the mesh is one closed surface, wound outwards, that does not cross itself."""
    solid = to_solid(mesh.vertices, mesh.faces)
    if not is_solid(solid) or solid.num_tri() != len(mesh.faces) or len(solid.decompose()) != 1:
        return False
    size = _size(mesh.vertices)
    thick = solid.volume() > FLAT * size**3
    return thick and len(crossings(mesh.vertices, mesh.faces, DEPTH * size)) == 0


def _largest(solid: Solid) -> Solid:
    """The part with the largest volume. The walls of voids are parts of negative volume."""
    parts = [part for part in solid.decompose() if is_solid(part)]
    if not parts:
        raise RejectedError("no volume")
    best = max(parts, key=lambda part: part.volume())
    low, high = np.reshape(best.bounding_box(), (2, 3))
    if not best.volume() > FLAT * float((high - low).max()) ** 3:
        raise RejectedError(THIN)
    return best


def _solids(mesh: trimesh.Trimesh) -> list[Solid]:
    """A solid for each shell. Shells that stay open are dropped if they are but debris."""
    solids, open_area, edges = [], 0.0, 0
    for shell in _shells(mesh):
        closed = close_holes(shell, LARGEST_HOLE)
        solid = None if closed is None else _outward(closed)
        if solid is None:
            open_area += shell.area
            edges += len(open_edges(shell.faces))
        else:
            solids.append(solid)
    if open_area > DEBRIS * mesh.area or not solids:
        raise RejectedError(_reason(edges))
    return solids


def _reason(edges: int) -> str:
    if edges == 0:
        return "faces without volume, or that meet in ways that no solid has"
    return f"open surface: {edges} open edges that could not be closed"


def _shells(mesh: trimesh.Trimesh) -> list[trimesh.Trimesh]:
    """Parts that hang together by edges with two faces, each wound consistently."""
    groups = trimesh.graph.connected_components(
        mesh.face_adjacency, nodes=np.arange(len(mesh.faces)), min_len=1
    )
    shells = []
    for group in sorted(map(sorted, groups)):
        shell = trimesh.Trimesh(mesh.vertices, mesh.faces[group], process=False)
        shell.remove_unreferenced_vertices()
        if not shell.is_winding_consistent:
            trimesh.repair.fix_winding(shell)
        shells.append(shell)
    return shells


def _outward(shell: trimesh.Trimesh) -> Solid | None:
    """The solid within a shell, turned round if it is inside out; None if it bounds nothing."""
    outward = shell.faces if shell.volume > 0 else shell.faces[:, ::-1]
    solid = to_solid(shell.vertices, outward)
    return solid if is_solid(solid) else None


def _welded(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Vertices at open edges that are closer than a crack become one."""
    rim = np.unique(trimesh.grouping.group_rows(mesh.edges_sorted, require_count=1))
    rim = np.unique(mesh.edges_sorted[rim])
    if len(rim) == 0:
        return mesh
    pairs = cKDTree(mesh.vertices[rim]).query_pairs(
        CRACK * _size(mesh.vertices), output_type="ndarray"
    )
    near = rim[pairs]
    count = len(mesh.vertices)
    links = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(count, count))
    _, group = csgraph.connected_components(links, directed=False)
    _, first = np.unique(group, return_index=True)
    return trimesh.Trimesh(mesh.vertices, first[group][mesh.faces], process=False)


def _cleaned(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Faces with three corners, each once; two that lie back to back are both removed."""
    faces = np.asarray(mesh.faces)
    ordered = np.sort(faces, axis=1)
    faces = faces[(ordered[:, 1:] != ordered[:, :-1]).all(axis=1)]
    _, first, group = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_inverse=True
    )
    turns = np.bincount(group, weights=_parity(faces))
    kept = np.flatnonzero(turns)
    if len(kept) == 0:
        raise RejectedError("no volume")
    same = np.sign(turns[kept]) == _parity(faces)[first[kept]]
    chosen = np.where(same[:, None], faces[first[kept]], faces[first[kept]][:, ::-1])
    return trimesh.Trimesh(mesh.vertices, chosen[np.argsort(first[kept])], process=False)


def _parity(faces: Ints) -> Floats:
    """+1 for faces whose corners ascend after a rotation, -1 for the others."""
    turns: Floats = np.sign(
        (faces[:, 1] - faces[:, 0]) * (faces[:, 2] - faces[:, 1]) * (faces[:, 0] - faces[:, 2])
    ).astype(np.float64)
    return turns


def _size(vertices: Floats) -> float:
    return float(np.ptp(vertices, axis=0).max())
