"""Whether an object can be printed as it is (ours): walls, thickness, size."""

from typing import NamedTuple

import numpy as np
import trimesh
from scipy.spatial import cKDTree
from trimesh.graph import connected_component_labels

from egad._util.arrays import Flags, Floats, Ints
from egad.evalset.parameters import PrintCheck
from egad.geometry import RayCaster, cone_volumes, is_closed, nearest, spread

SPACING = 0.8  # of the diameter: longest side of the pieces that triangles are cut into
SLACK = 0.95  # of the radius: a ball that touches one facet of a curve cuts into the next
PARALLEL = np.cos(np.radians(30))  # of the angle between the sides of a wall, at most
GRAIN = 0.25  # radii between balls that are told apart
LINK = 2.4  # radii between balls that may be connected
SKIN = 1e-3  # of the diameter: rays start this deep
TURN = 0.5  # radians between the normals at a reflex edge, at most
STUB = 0.5  # of the thinnest wall: thin parts that protrude less are not walls


class Thinness(NamedTuple):
    """What a ball of a given diameter, rolled inside a solid, cannot reach.

    Each is a distance, in the unit of the mesh; inf if the ball fits nowhere.

    Attributes:
        edge: Largest distance of the surface from what the ball reaches. A flat face has 0, a
            right-angled edge 0.21 diameters, an edge or the tip of a cone of angle t
            (1 / sin(t / 2) - 1) / 2.
        wall: The same, only for surface with other surface less than the diameter behind it,
            parallel within 30 degrees: fins, films, rods, and the sharpest edges and tips.
        part: Largest distance of a ball from the largest part of the solid that one can roll
            through.
    """

    edge: float
    wall: float
    part: float


def thinness(mesh: trimesh.Trimesh, diameter: float) -> Thinness:
    """Roll a ball inside a solid: the morphological opening, measured on the surface.

    A point of the surface is reached if the ball that touches it from within meets no other part of
    the surface. What the ball reaches is the union of these balls.
    """
    radius = diameter / (1 + SLACK)  # so that a plate passes if it is as thick as the diameter
    flat, bent = spread(mesh, SPACING * diameter), rims(mesh, SPACING * diameter)
    points, normals = map(np.concatenate, zip(flat[:2], bent, strict=True))
    depth, parallel = _behind(mesh, points, normals, SKIN * diameter)
    reached = depth > radius
    balls, reached[reached] = _balls(mesh, (points - radius * normals)[reached], radius)
    if not len(balls):
        return Thinness(np.inf, np.inf, np.inf)
    lost = np.flatnonzero(~reached[: len(flat.points)])
    away = _away(points[lost], balls) - radius
    thin = parallel[lost] & (depth[lost] < diameter)
    apart = _apart(mesh, balls, radius)
    return Thinness(*(float(each.max(initial=0.0)) for each in (away, away[thin], apart)))


def _behind(
    mesh: trimesh.Trimesh, points: Floats, normals: Floats, skin: float
) -> tuple[Floats, Flags]:
    """How deep the solid is behind its surface, and whether the other side is parallel there."""
    hits = RayCaster(mesh).first_hits(points - skin * normals, -normals)
    facing = -np.einsum("nk,nk->n", hits.normals, normals)
    film = hits.entering | ~np.isfinite(hits.distances)  # thinner than the skin
    return np.where(film, 0.0, hits.distances + skin), film | (facing >= PARALLEL)


def _balls(mesh: trimesh.Trimesh, centers: Floats, radius: float) -> tuple[Floats, Flags]:
    """Centers of balls that fit, and which of the given ones do.

    A ball that does not fit is pushed away from the surface that it meets, to find the narrow space
    where it may fit, as in a square rod.
    """
    distances, met = nearest(centers, mesh)
    fits = distances >= SLACK * radius
    pushed = ~fits & (distances > (1 - SLACK) * radius)  # nearer, it might leave the solid
    away = (centers[pushed] - met[pushed]) / distances[pushed, None]
    others = met[pushed] + radius * away
    return np.concatenate([centers[fits], others[_fits(mesh, others, radius)]]), fits


def _fits(mesh: trimesh.Trimesh, centers: Floats, radius: float) -> Flags:
    return np.asarray(nearest(centers, mesh)[0] >= SLACK * radius)


def _apart(mesh: trimesh.Trimesh, balls: Floats, radius: float) -> Floats:
    """Distances to the largest part, of the balls that are not connected to it.

    Balls a radius apart overlap so much that 0.8 of the diameter passes from one to the other.
    Balls further apart are connected if a ball also fits midway: then 0.75 passes.
    """
    balls = _thinned(balls, GRAIN * radius)
    tree = _tree(balls)
    near = tree.query_pairs(radius, output_type="ndarray")
    parts = connected_component_labels(near, node_count=len(balls))
    rest = np.flatnonzero(parts != np.bincount(parts).argmax())
    if not len(rest):
        return np.empty(0)
    around = _tree(balls[rest]).sparse_distance_matrix(tree, LINK * radius, output_type="ndarray")
    far = np.column_stack([rest[around["i"]], around["j"]])
    far = far[parts[far[:, 0]] != parts[far[:, 1]]]
    far = far[_fits(mesh, balls[far].mean(axis=1), radius)]
    parts = connected_component_labels(np.concatenate([near, far]), node_count=len(balls))
    main = parts == np.bincount(parts).argmax()
    return _away(balls[~main], balls[main])


def _thinned(points: Floats, grain: float) -> Floats:
    """The first point of each cell of a grid, cell by cell: the others are close to them."""
    cells = np.round(points / grain).astype(np.int64)
    x, y, z = (cells - cells.min(axis=0)).T
    numbers = (x * (y.max() + 1) + y) * (z.max() + 1) + z
    return points[np.unique(numbers, return_index=True)[1]]


def _away(points: Floats, others: Floats) -> Floats:
    """Distance of each point to the nearest of others, (n,)."""
    if not len(points):
        return np.empty(0)
    return np.asarray(_tree(others).query(points)[0], dtype=np.float64)


def _tree(points: Floats) -> cKDTree:
    """A search tree of points: built quickly, because it is not queried often."""
    return cKDTree(points, balanced_tree=False, compact_nodes=False)


def print_problems(mesh: trimesh.Trimesh, check: PrintCheck) -> list[str]:
    """What keeps an object, metres, from being printed at its present size, in a few words each.

    It must be closed, one body that does not touch itself, without a trapped void, and nowhere
    thinner than the nozzle allows: a ball as wide as the thinnest wall, rolled inside, must come
    close to all of the surface, and get from any place to any other. Edges and tips may become
    blunter by as much as the settings allow; where both sides are parallel within 30 degrees, half
    a wall is the limit.
    """
    if not is_closed(mesh):
        return ["not closed"]
    volumes = shell_volumes(mesh)
    if sum(volumes) <= 0:
        return ["wound inwards"]
    problems = []
    if touching := _touching(mesh):
        problems.append(f"touches itself {touching}")
    elif (bodies := sum(volume > 0 for volume in volumes)) != 1:
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


def _touching(mesh: trimesh.Trimesh) -> str:
    """Where edges have more than two faces, or else shells meet in a vertex; empty if nowhere.

    A shell that meets itself in a vertex, or along a part of an edge, is not noticed.
    """
    merged = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    merged.merge_vertices()
    what = "along an edge"
    touching = merged.edges_unique[np.bincount(merged.edges_unique_inverse) > 2]
    if not len(touching):
        what, shells = "in a point", np.repeat(_shells(merged)[:, None], 3, axis=1)
        lowest = np.full(len(merged.vertices), len(merged.faces))
        np.minimum.at(lowest, merged.faces, shells)
        touching = merged.faces[lowest[merged.faces] < shells]
    if not len(touching):
        return ""
    place = np.reshape(merged.vertices[touching[0]], (-1, 3)).mean(axis=0)
    x, y, z = np.round(1000 * place, 2) + 0.0  # no -0
    return f"{what} near ({x:.2f}, {y:.2f}, {z:.2f}) mm"


def _shells(mesh: trimesh.Trimesh) -> Ints:
    """Number of the shell of each face, (m,)."""
    labels: Ints = connected_component_labels(mesh.face_adjacency, node_count=len(mesh.faces))
    return labels


def shell_volumes(mesh: trimesh.Trimesh) -> list[float]:
    """Volume within each closed shell, m3; that of a shell around a void is negative."""
    volumes = cone_volumes(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    totals: list[float] = np.bincount(_shells(mesh), weights=volumes).tolist()
    return totals


def rims(mesh: trimesh.Trimesh, spacing: float) -> tuple[Floats, Floats]:
    """Points along the reflex edges, and normals there from one side to the other, (n, 3)."""
    angles = np.asarray(mesh.face_adjacency_angles)
    bent = ~np.asarray(mesh.face_adjacency_convex) & (angles > TURN) & (angles < np.pi - 1e-6)
    angles = angles[bent]
    ends = np.asarray(mesh.vertices)[np.asarray(mesh.face_adjacency_edges)[bent]]
    sides = np.asarray(mesh.face_normals)[np.asarray(mesh.face_adjacency)[bent]]
    steps = np.ceil(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / spacing).astype(np.int64)
    turns = np.ceil(angles / TURN).astype(np.int64) + 1
    edge = np.repeat(np.arange(len(angles)), steps * turns)
    number = np.arange(len(edge)) - np.searchsorted(edge, edge)
    along = (number // turns[edge] + 0.5) / steps[edge]
    turned = (number % turns[edge]) / (turns[edge] - 1)
    weights = np.sin(np.column_stack([1 - turned, turned]) * angles[edge, None])
    normals = np.einsum("ij,ijk->ik", weights / np.sin(angles[edge])[:, None], sides[edge])
    points = np.einsum("ij,ijk->ik", np.column_stack([1 - along, along]), ends[edge])
    return points, normals
