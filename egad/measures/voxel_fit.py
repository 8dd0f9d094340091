"""The voxels of a grid whose smoothed surface is closest to a mesh."""

from typing import NamedTuple, Self

import numpy as np
import trimesh
from scipy.ndimage import uniform_filter
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from egad._util.arrays import Flags, Floats
from egad.geometry import VOXELS, RayCaster, Smoothing, TriangleScene, spread, voxel_surface

FINE, COARSE = 0.9, 2.0  # distances of points on the mesh, voxels
MAX_POINTS, FEW_POINTS = 200_000, 20_000  # of a mesh of many triangles
NORMAL_WEIGHT = 0.7  # voxels in which normals of length 1 are compared together with points
THIN, THICKENED = 0.6, 1.1  # units: less than 1 % of the surface of any released object is thin
DEEP = 2  # voxels: further from the surface, all are alike
INWARDS = 1e-4  # units under the surface, where rays start
REVERTED = 0.3  # voxels that a change that did not help is moved away from
MAX_SCALING, MAX_TURN = 0.05, 0.1  # of an alignment, fraction and radians
CLOSE = 0.05  # voxels: surfaces further apart count less in an alignment


class FitTarget:
    """A mesh to fit voxels to, 25 units long about the origin; walls below 0.6 units become 1.1."""

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        low, high = mesh.bounds
        vertices = (mesh.vertices - (low + high) / 2) * (VOXELS / (high - low).max())
        # rounded, so that the unit of the mesh does not matter
        scaled = trimesh.Trimesh(np.round(vertices, 9), mesh.faces, process=False)
        scaled.remove_unreferenced_vertices()
        fine, coarse = spread(scaled, FINE), spread(scaled, COARSE)
        some = slice(None, None, 1 + len(fine.points) // MAX_POINTS)
        positions, self.normals = fine.points[some], fine.normals[some]
        self._rays = RayCaster(scaled)
        self._positions = cKDTree(positions)
        scene = TriangleScene(scaled.vertices, scaled.faces)
        self._growth = _growth(scene, positions, self.normals)
        self.points = positions + self._growth[:, None] * self.normals
        some = slice(None, None, 1 + len(coarse.points) // FEW_POINTS)
        positions, self.few_normals = coarse.points[some], coarse.normals[some]
        growth = _growth(scene, positions, self.few_normals)
        self.few_points = positions + growth[:, None] * self.few_normals
        self.face_normals, self.areas = np.asarray(scaled.face_normals), scaled.area_faces
        self.spacing = np.sqrt(scaled.area / len(scaled.vertices))  # of the mesh's own vertices
        self._tree = cKDTree(np.hstack([self.points, NORMAL_WEIGHT * self.normals]))
        self.vertices = np.asarray(scaled.vertices)

    def inside(self, points: Floats) -> Flags:
        """Whether points (n, 3) are inside the mesh, (n,)."""
        if self._growth.any():
            return self.depths(points, DEEP) > 0
        return self._rays.contains(points)

    def depths(self, points: Floats, most: float) -> Floats:
        """How deep points (n, 3) lie inside, (n,), at most a bound; negative outside."""
        distances, index = self._positions.query(points, distance_upper_bound=most)
        sides = np.where(self._rays.contains(points), 1, -1)
        growth = np.append(self._growth, 0.0)[index]  # of points further away, the last
        return np.asarray(np.minimum(distances, most) * sides + growth)

    def nearest(self, points: Floats, normals: Floats) -> tuple[Floats, Floats]:
        """Heights (n,) of the mesh over oriented points, (n, 3) each, and its normals there."""
        _, index = self._tree.query(np.hstack([points, NORMAL_WEIGHT * normals]))
        there = self.normals[index]
        return np.einsum("ij,ij->i", self.points[index] - points, there), there


class Grid(NamedTuple):
    """Cubes in the units of a `FitTarget`."""

    origin: Floats  # (3,) center of the first
    frame: Floats  # (3, 3) unit vectors along its axes, as rows
    pitch: float  # their side
    shape: tuple[int, ...]  # their numbers along the axes

    @classmethod
    def around(cls, target: FitTarget, frame: Floats, pitch: float, plane: Floats) -> Self:
        """The grid around a target, given where along each axis a plane between cubes is, (3,)."""
        along = target.vertices @ frame.T
        first = np.floor((along.min(axis=0) - plane) / pitch - 0.5) - 1
        start = plane + pitch * (first + 0.5)
        shape = np.ceil((along.max(axis=0) - start) / pitch).astype(int) + 2
        return cls(start @ frame, frame, pitch, tuple(shape.tolist()))

    def place(self, points: Floats) -> Floats:
        """Positions of points (n, 3) in numbers of cubes."""
        return self.origin + self.pitch * points @ self.frame

    def centers(self) -> Floats:
        """Centers of all cubes, (n, 3)."""
        numbers = np.moveaxis(np.indices(self.shape, float), 0, -1)
        return self.place(numbers.reshape(-1, 3))


class Fit(NamedTuple):
    """Voxels, and how far their surface is from the target."""

    grid: Grid
    voxels: Flags  # which of its cubes are solid
    surface: trimesh.Trimesh  # their smoothed surface, in numbers of cubes
    normals: Floats  # (v, 3) outward unit normals of its vertices
    deviation: float  # root mean square distance of its vertices from the target, in cubes
    offsets: Floats  # mean height of the target over the surface near each cube, in cubes
    errors: Floats  # mean square of these heights near each cube and its neighbors

    @property
    def size(self) -> float:
        """The deviation in the units of the target."""
        return self.deviation * self.grid.pitch


def _growth(scene: TriangleScene, points: Floats, normals: Floats) -> Floats:
    """How far the surface at points (n, 3) is moved outwards so that no wall is thin, (n,)."""
    thickness = scene.distances(points - INWARDS * normals, -normals)
    return np.where(thickness < THIN, (THICKENED - thickness) / 2, 0.0)


def fit(target: FitTarget, grid: Grid, rounds: int) -> Fit | None:
    """Voxels whose smoothed surface is close to the target (ours, after van Cittert).

    None if no cube's center is inside. Each round keeps only changes that bring the surface closer.
    """
    depths = target.depths(grid.centers(), DEEP * grid.pitch).reshape(grid.shape) / grid.pitch
    if not (depths > 0).any():
        return None
    best, moved = compare(target, grid, depths > 0), np.zeros(grid.shape)
    for _ in range(rounds):
        moved += best.offsets
        proposed = depths + moved > 0
        if not proposed.any() or (proposed == best.voxels).all():
            continue  # what is left of the offsets adds up until it changes a cube
        other = compare(target, grid, proposed)
        worse = (proposed != best.voxels) & (other.errors >= best.errors)
        # not proposed again before the offsets add up again
        moved[worse] = np.where(best.voxels, REVERTED, -REVERTED)[worse] - depths[worse]
        kept = np.where(worse, best.voxels, proposed)
        if (kept != best.voxels).any():
            best = other if not worse.any() else compare(target, grid, kept)
    return best


def compare(target: FitTarget, grid: Grid, voxels: Flags) -> Fit:
    """How far the surface of voxels is from the target, seen from both."""
    sharp, surface, normals = _surface(voxels)
    points = np.asarray(surface.vertices)
    heights = _heights(target, grid, points, normals)
    ends = [(np.floor(sharp), heights), (np.ceil(sharp), heights)]
    seen = (target.few_points - grid.origin) @ grid.frame.T / grid.pitch
    ways = target.few_normals @ grid.frame.T
    tree = cKDTree(np.hstack([points, NORMAL_WEIGHT * normals]))
    _, index = tree.query(np.hstack([seen, NORMAL_WEIGHT * ways]))
    back = np.clip(np.einsum("ij,ij->i", seen - points[index], normals[index]), -1, 1)
    ends += [(np.round(seen - ways / 2), back), (np.round(seen + ways / 2), back)]
    count, total, squares = _sums(ends, grid.shape)
    errors = uniform_filter(squares, 3) / np.maximum(uniform_filter(count, 3), 1e-9)
    offsets = total / np.maximum(count, 1)
    return Fit(grid, voxels, surface, normals, _root_mean_square(heights), offsets, errors)


def deviation(target: FitTarget, grid: Grid, most: int) -> float:
    """The deviation of the cubes with centers in the target, from at most about `most` vertices."""
    voxels = target.inside(grid.centers()).reshape(grid.shape)
    if not voxels.any():
        return np.inf
    _, surface, normals = _surface(voxels)
    some = slice(None, None, max(1, len(normals) // most))
    points = np.asarray(surface.vertices)[some]
    return _root_mean_square(_heights(target, grid, points, normals[some]))


def _heights(target: FitTarget, grid: Grid, points: Floats, normals: Floats) -> Floats:
    """Heights (n,) of the target over oriented points of a grid, in cubes, between -1 and 1."""
    heights, _ = target.nearest(grid.place(points), normals @ grid.frame)
    return np.clip(heights / grid.pitch, -1, 1)


def _root_mean_square(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def aligned(target: FitTarget, best: Fit, turn: bool) -> Grid:
    """The grid of voxels moved, scaled and perhaps turned so that their surface fits better."""
    grid, points = best.grid, np.asarray(best.surface.vertices)
    placed = grid.place(points)
    heights, normals = target.nearest(placed, best.normals @ grid.frame)
    middle = placed.mean(axis=0)
    arms = placed - middle
    columns = [np.einsum("ij,ij->i", arms, normals)[:, None], normals]
    columns += [np.cross(arms, normals)] if turn else []
    weights = 1 / (1 + (heights / (CLOSE * grid.pitch)) ** 2)
    terms = np.hstack(columns)
    matrix = np.einsum("ni,n,nj->ij", terms, weights, terms)
    moves = np.linalg.solve(
        matrix + 1e-9 * np.trace(matrix) * np.eye(len(matrix)),
        np.einsum("ni,n,n->i", terms, weights, heights),
    )
    scale = 1 + np.clip(moves[0], -MAX_SCALING, MAX_SCALING)
    shift = np.clip(moves[1:4], -grid.pitch, grid.pitch)
    rotation = Rotation.from_rotvec(np.clip(moves[4:], -MAX_TURN, MAX_TURN)) if turn else None
    frame = rotation.apply(grid.frame) if rotation else grid.frame
    pitch = grid.pitch * scale
    origin = middle + shift + scale * (grid.origin - middle) @ grid.frame.T @ frame
    return Grid.around(target, frame, pitch, frame @ origin + pitch / 2)


def _surface(voxels: Flags) -> tuple[Floats, trimesh.Trimesh, Floats]:
    """Vertices before smoothing, in numbers of cubes, and the smooth surface with its normals."""
    sharp, surface = voxel_surface(voxels, Smoothing())
    surface.vertices -= 1
    first, second, third = np.moveaxis(np.asarray(surface.triangles), 1, 0)
    outwards = np.cross(second - first, third - first)
    sums = [np.bincount(surface.faces.ravel(), np.repeat(way, 3)) for way in outwards.T]
    normals = np.column_stack(sums)
    lengths = np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return sharp.astype(float) - 1, surface, normals / lengths


def _sums(
    ends: list[tuple[Floats, Floats]], shape: tuple[int, ...]
) -> tuple[Floats, Floats, Floats]:
    """Number, sum and sum of squares of values in each cube of a grid."""
    cells, values = map(np.concatenate, zip(*ends, strict=True))
    cells = np.clip(cells.astype(int), 0, np.array(shape) - 1)
    index = np.ravel_multi_index(tuple(cells.T), shape)
    size = int(np.prod(shape))

    def summed(weights: Floats) -> Floats:
        return np.asarray(np.bincount(index, weights, size), float).reshape(shape)

    return summed(np.ones(len(values))), summed(values), summed(values**2)
