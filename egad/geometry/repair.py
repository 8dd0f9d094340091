"""Repair any triangle mesh into one closed surface that bounds a solid, or say why it fails."""

import logging
from collections.abc import Iterator
from typing import NamedTuple, cast, get_args

import manifold3d
import numpy as np
import pandas as pd
import trimesh
from scipy.spatial import cKDTree
from trimesh.graph import connected_component_labels

from egad._util.arguments import check_positive
from egad._util.arrays import Floats, Ints
from egad._util.display import facts_html
from egad.errors import RejectedError, check_name
from egad.geometry.checks import (
    DroppedBodiesWarning,
    check_surface,
    cone_volumes,
    is_closed,
    warn_user,
)
from egad.geometry.manifold import Solid, arrays, bodies, is_solid, to_mesh, to_solid, union
from egad.geometry.parameters import SHELL_THICKNESS, OpenSurfaces
from egad.geometry.rays import RayCaster
from egad.geometry.rounding import in_single_precision, is_single
from egad.geometry.self_intersections import DEPTH, crossings, untangle
from egad.geometry.shell import shell
from egad.geometry.touching import wedge_pairs

log = logging.getLogger(__name__)

Loop = list[int]


def open_edges(faces: Ints) -> Ints:
    """Edges (a, b) that a missing triangle would have, (n, 2): b to a has one face, a to b none."""
    there = np.asarray(faces)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    wanted = there[:, ::-1]
    keys, count = np.unique(np.vstack([there, wanted]), axis=0, return_inverse=True)
    surplus = np.bincount(count[: len(there)], minlength=len(keys))
    surplus -= np.bincount(count[len(there) :], minlength=len(keys))
    return np.asarray(np.repeat(keys, np.maximum(-surplus, 0), axis=0))


def close_holes(mesh: trimesh.Trimesh, largest: float) -> trimesh.Trimesh | None:
    """Fill holes by triangulating rims along their normals (ours); None if it cannot be done."""
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
    centered = rim - rim.mean(axis=0)
    normal = np.cross(centered, np.roll(centered, -1, axis=0)).sum(axis=0)
    if not normal.any():
        return np.empty((0, 3), dtype=np.int64)
    to_plane = trimesh.geometry.align_vectors(normal, [0, 0, 1])
    seen = np.ascontiguousarray((centered @ to_plane[:3, :3].T)[:, :2])
    return np.asarray(manifold3d.triangulate([seen])).astype(np.int64).reshape(-1, 3)


CRACK = 1e-4  # of the longest side: open edges that are this close belong together
MAX_HOLE = 0.1  # of the area of a shell; a larger one may be the mouth of a cup
DEBRIS = 0.1  # of the area of all shells: open shells that together have less are dropped
FLAT = 1e-6  # volume / longest side cubed: thinner than this bounds nothing
THICKEN = "`open_surfaces: thicken` gives a surface without thickness a wall"
CRUMB = 1e-4  # of the volume of the largest body: smaller ones are not counted as left out
THIN = f"no volume, or less than {FLAT:g} of the cube of its longest side"


class Repaired(NamedTuple):
    """A closed surface, and what was done to get it.

    Attributes:
        mesh: The surface, wound outwards.
        changed: Whether more than merging vertices was needed.
        shell_thickness: Thickness of the wall that an open surface was given; 0 for all others.
        dropped_bodies: Number of bodies, closed or open, that were left out because only the
            largest closed one is kept.
        dropped_volume: Their fraction of the volume of all bodies, with holes closed; open surfaces
            without volume have none.
    """

    mesh: trimesh.Trimesh
    changed: bool
    shell_thickness: float = 0.0
    dropped_bodies: int = 0
    dropped_volume: float = 0.0

    def __repr__(self) -> str:
        return f"Repaired({', '.join(self._facts().values())})"

    def _repr_html_(self) -> str:
        return facts_html("Repaired", self._facts(), self.mesh)

    def _facts(self) -> dict[str, str]:
        facts = {
            "mesh": f"{len(self.mesh.faces)} faces",
            "repair": "changed" if self.changed else "unchanged",
        }
        if self.shell_thickness:
            facts["wall"] = f"{1000 * self.shell_thickness:g} mm thick"
        if self.dropped:
            facts["left out"] = self.dropped
        return facts

    @property
    def dropped(self) -> str:
        """What was left out, as a phrase; empty if nothing was."""
        return dropped_text(self.dropped_bodies, self.dropped_volume)


def repair(
    mesh: trimesh.Trimesh,
    open_surfaces: OpenSurfaces = "reject",
    thickness: float = SHELL_THICKNESS,
) -> Repaired:
    """The outer surface of the largest solid body of a mesh.

    A mesh that already is one closed surface without crossings is returned with its triangles
    unchanged. Otherwise: cracks are welded; faces without area and doubled faces removed; every
    shell is wound outwards and its small holes closed; the union of the shells is taken, which
    removes overlaps and the walls of trapped voids; its largest body by volume is kept, and regions
    where it passes through itself are cut out and rebuilt. Parts that share a vertex or an edge are
    one body; that they touch elsewhere, as along a part of an edge, is not noticed.

    A surface that stays open, such as the scan of a glass, can be thickened: it becomes the middle
    of a wall with round rims. A side of the box grows by at most the thickness.

    Args:
        mesh: In metres; in any unit if nothing is thickened. Not changed.
        open_surfaces: `reject` or `thicken`.
        thickness: Thickness of that wall, metres; common cups and glasses have the default, 2 mm.

    Returns:
        The surface, in which every edge has as many faces in one direction as in the other, and
        what was done.

    Raises:
        RejectedError: The mesh is not finite, has no area or no volume, holes too large to close,
            or faces that no solid can have.
        UserError: It is not a mesh, or an option is not among those allowed.

    Source: not in the EGAD paper; built on manifold3d.
    """
    check_name("open_surfaces", open_surfaces, get_args(OpenSurfaces))
    check_positive("thickness", thickness)
    check_surface(mesh)
    merged = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    merged.merge_vertices(merge_tex=True, merge_norm=True)
    if _is_sound(merged):
        return Repaired(merged, changed=False)
    wall = thickness if open_surfaces == "thicken" else None
    solids, open_shells, thickened = _solids(_welded(merged), wall)
    solid, others = _largest(union(solids))
    if any(_crosses_itself(*arrays(each)) for each in solids):
        solid, more = _largest(untangle(solid))
        others += more
    dropped = _dropped(others, open_shells, solid)
    return Repaired(to_mesh(solid), True, thickness if thickened else 0.0, *dropped)


def repair_for_files(
    mesh: trimesh.Trimesh,
    open_surfaces: OpenSurfaces = "reject",
    thickness: float = SHELL_THICKNESS,
) -> Repaired:
    """Like `repair`, in single precision unless rounding makes the surface cross itself."""
    found = repair(mesh, open_surfaces, thickness)
    if is_single(found.mesh.vertices):
        return found
    rounded = in_single_precision(found.mesh)
    return found._replace(mesh=rounded) if _is_sound(rounded) else found


def repair_with_warning(mesh: trimesh.Trimesh) -> Repaired:
    """A mesh as `repair_for_files` repairs it, with a warning if bodies were left out."""
    repaired = repair_for_files(mesh)
    if repaired.dropped:
        warn_user(f"only the largest body is used: {repaired.dropped}", DroppedBodiesWarning)
    return repaired


def dropped_text(bodies: int, volume: float) -> str:
    """How many bodies were left out and their share of the volume, as a phrase; empty for none."""
    if not bodies:
        return ""
    was = "was" if bodies == 1 else "were"
    part = f"{100 * volume:.{2 if volume < 0.99 else 4}g} % of the volume"
    if not volume:
        part = f"at most {100 * DEBRIS:.2g} % of the area"
    return f"{bodies} of {bodies + 1} bodies {was} dropped, {part}"


def _is_sound(mesh: trimesh.Trimesh) -> bool:
    """Whether the mesh is one closed surface, wound outwards, that does not cross itself."""
    solid = to_solid(mesh.vertices, mesh.faces)
    if not is_solid(solid) or solid.num_tri() != len(mesh.faces) or len(bodies(solid).volumes) != 1:
        return False
    thick = solid.volume() > FLAT * _size(mesh.vertices) ** 3
    return thick and not _crosses_itself(mesh.vertices, mesh.faces)


def _crosses_itself(vertices: Floats, faces: Ints) -> bool:
    return len(crossings(vertices, faces, DEPTH * _size(vertices))) > 0


def _largest(solid: Solid) -> tuple[Solid, list[float]]:
    """The body with the largest volume, without trapped voids, and the volumes of the others."""
    if not is_solid(solid):
        raise RejectedError("no volume")
    found = bodies(solid)
    volumes = np.bincount(found.groups, np.maximum(found.volumes, 0))
    best = int(volumes.argmax())
    kept = ((found.groups == best) & (found.volumes > 0))[found.shells]
    used, corners = np.unique(found.faces[kept], return_inverse=True)
    vertices = found.vertices[used]
    if not kept.any() or not volumes[best] > FLAT * _size(vertices) ** 3:
        raise RejectedError(THIN)
    others = [float(each) for each in np.delete(volumes, best)]
    return (solid if kept.all() else to_solid(vertices, corners.reshape(-1, 3))), others


def _dropped(
    others: list[float], open_shells: list[trimesh.Trimesh], kept: Solid
) -> tuple[int, float]:
    """How many closed and open bodies were left out, and their fraction of the volume."""
    dropped = [each for each in others if each > CRUMB * kept.volume()]
    if open_shells:
        rays, least = RayCaster(to_mesh(kept)), CRUMB ** (2 / 3) * kept.surface_area()
        for each in open_shells:
            outside = ~rays.contains(each.triangles_center)
            if each.area_faces[outside].sum() > least:
                dropped.append(_volume_beyond(each, kept))
    return len(dropped), float(sum(dropped) / (sum(dropped) + kept.volume()))


def _volume_beyond(open_shell: trimesh.Trimesh, kept: Solid) -> float:
    """Volume that a shell bounds outside a solid once its holes are closed; 0 for sheets."""
    closed = close_holes(open_shell, np.inf)
    with np.errstate(invalid="ignore"):  # trimesh divides by the volume
        solid = None if closed is None else _outward(closed)
    volume = 0.0 if solid is None else float((solid - kept).volume())
    return volume if volume > CRUMB * kept.volume() else 0.0


def _solids(
    mesh: trimesh.Trimesh, wall: float | None
) -> tuple[list[Solid], list[trimesh.Trimesh], bool]:
    """Solids of shells that close or get a wall, debris to drop, and whether there is a wall."""
    single, doubled = _cleaned(mesh)
    solids, failed = list[Solid](), list[trimesh.Trimesh]()
    for part in _shells(single):
        closed = part if is_closed(part) else close_holes(part, MAX_HOLE)
        solid = None if closed is None else _outward(closed)
        if solid is None:
            failed.append(part)
        else:
            solids.append(solid)
    if solids and sum(part.area for part in failed) <= DEBRIS * single.area:
        return solids, failed, False
    sheets = cast("trimesh.Trimesh", trimesh.util.concatenate([*failed, doubled]))
    if wall is None or len(open_edges(sheets.faces)) == 0:
        raise RejectedError(_reason(failed))
    return [*solids, shell(sheets, wall)], [], True


def _reason(failed: list[trimesh.Trimesh]) -> str:
    if not failed:
        return f"no volume; {THICKEN}"
    edges = sum(len(open_edges(part.faces)) for part in failed)
    if edges == 0:
        return "faces that enclose no volume, or meet in ways that no solid allows"
    return f"open surface: {edges} open edges that could not be closed; {THICKEN}"


def _shells(mesh: trimesh.Trimesh) -> Iterator[trimesh.Trimesh]:
    """Parts connected by edges; each is closed or wound consistently."""
    faces = np.asarray(mesh.faces)
    links = np.vstack([mesh.face_adjacency, wedge_pairs(np.asarray(mesh.vertices), faces) // 3])
    shells = connected_component_labels(links, node_count=len(mesh.faces))
    order, ends = np.argsort(shells, kind="stable"), np.cumsum(np.bincount(shells))
    for group in np.split(order, ends[:-1]) if len(order) else []:
        used, corners = np.unique(mesh.faces[group], return_inverse=True)
        part = trimesh.Trimesh(mesh.vertices[used], corners.reshape(-1, 3), process=False)
        if not is_closed(part) and not part.is_winding_consistent:
            trimesh.repair.fix_winding(part)
        yield part


def _outward(part: trimesh.Trimesh) -> Solid | None:
    """The solid within a closed surface, flipped if it is inside out; None if it bounds nothing."""
    inside_out = cone_volumes(part.vertices, part.faces).sum() < 0
    solid = to_solid(part.vertices, part.faces[:, ::-1] if inside_out else part.faces)
    return solid if is_solid(solid) else None


def _welded(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Merge vertices at open edges that are closer than a crack."""
    rim = np.unique(trimesh.grouping.group_rows(mesh.edges_sorted, require_count=1))
    rim = np.unique(mesh.edges_sorted[rim])
    if len(rim) == 0:
        return mesh
    pairs = cKDTree(mesh.vertices[rim]).query_pairs(
        CRACK * _size(mesh.vertices), output_type="ndarray"
    )
    group = trimesh.graph.connected_component_labels(rim[pairs], node_count=len(mesh.vertices))
    _, first = np.unique(group, return_index=True)
    return trimesh.Trimesh(mesh.vertices, first[group][mesh.faces], process=False)


def _cleaned(mesh: trimesh.Trimesh) -> tuple[trimesh.Trimesh, trimesh.Trimesh]:
    """Faces with three corners, without duplicates, and one of each pair that lies back to back."""
    faces = np.asarray(mesh.faces)
    ordered = np.sort(faces, axis=1)
    faces = faces[(ordered[:, 1:] != ordered[:, :-1]).all(axis=1)]
    _, first, group = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_inverse=True
    )
    turns = np.bincount(group, weights=_parity(faces), minlength=len(first))
    kept, doubled = np.flatnonzero(turns), np.flatnonzero(turns == 0)
    same = np.sign(turns[kept]) == _parity(faces)[first[kept]]
    chosen = np.where(same[:, None], faces[first[kept]], faces[first[kept]][:, ::-1])
    single = chosen[np.argsort(first[kept])]
    return (
        trimesh.Trimesh(mesh.vertices, single, process=False),
        trimesh.Trimesh(mesh.vertices, faces[first[doubled]], process=False),
    )


def _parity(faces: Ints) -> Floats:
    """+1 for faces whose corners ascend after a rotation, -1 for the others."""
    turns: Floats = np.sign(
        (faces[:, 1] - faces[:, 0]) * (faces[:, 2] - faces[:, 1]) * (faces[:, 0] - faces[:, 2])
    ).astype(np.float64)
    return turns


def _size(vertices: Floats) -> float:
    return float(np.ptp(vertices, axis=0).max())


def repaired_mesh(mesh: trimesh.Trimesh, name: str) -> trimesh.Trimesh:
    """The repaired mesh, or `RejectedError`; the log says which bodies were left out."""
    repaired = repair(mesh)
    if repaired.dropped:
        log.warning("%s: %s", name, repaired.dropped)
    return repaired.mesh


def warn_of_shapes(table: pd.DataFrame, prefix: str = "") -> None:
    """Warn of meshes that lost bodies; the first column of the table has their names."""
    names = table.iloc[:, 0]
    dropped = table["dropped_bodies"] > 0
    bodies, volumes = table["dropped_bodies"][dropped], table["dropped_volume"][dropped]
    for name, count, volume in zip(names[dropped], bodies, volumes, strict=True):
        log.warning("%s%s: %s", prefix, name, dropped_text(int(count), volume))
