"""Complexity that compares with evolved objects: of the voxels that are closest to a mesh.

The vertices of evolved objects lie where marching cubes put them, on voxels of a known size. The
voxels of a released object are recovered from any mesh of its surface; any other mesh gets the
voxels that an evolved object of its shape would have.

The constants were set on released objects and their copies, other ones than those that
docs/measures.md reports.
"""

from collections.abc import Iterator
from itertools import product
from operator import attrgetter

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.geometry import VOXELS, check_mesh
from egad.measures.complexity import complexity
from egad.measures.parameters import BINS
from egad.measures.voxel_fit import Fit, FitTarget, Grid, aligned, deviation, fit

SIDES = np.linspace(24, 25.2, 7)  # voxels along objects of the dataset, after smoothing
OWN_SPACING = (0.65, 1.0)  # distances of the vertices of evolved and published objects, voxels
MIN_HALF_SQUARES = (
    0.235  # of their triangles at least are halves of squares; of remeshed ones, fewer
)
NOISE = 0.1  # bits: an own complexity that is higher than the resampled one has noise
REGULAR = 0.55  # of the resampled one: less is that of a regular grid, not of an evolved object
SMALLEST = 6.5  # objects that are fewer voxels long are not looked for
DENSITY = (0.7, 0.86)  # distances of the vertices of evolved objects, voxels
CLEARLY = 0.7  # of the deviation on 25 voxels, on fewer
GOOD, FAIR = 0.06, 0.07  # deviations, voxels: of recovered objects, and of others at least
SCORED = 1000  # vertices that tell a bad grid
TURNS = 50  # of the search for axes
FLAT = 0.9  # cosine between an axis and the normals of faces between two voxels
_deviation = attrgetter("deviation")  # of a `Fit`
_TURNS = [*np.eye(3) * np.pi / 8, *np.eye(3) * -np.pi / 8, *np.eye(3) * np.pi / 4]
_STARTS = [np.eye(3), *Rotation.from_rotvec([*_TURNS, np.full(3, np.pi / 27**0.5)]).as_matrix()]


def map_complexity(mesh: trimesh.Trimesh, bins: int = BINS) -> float:
    """Complexity, bits, that places a closed mesh on the map, whatever its triangles (ours).

    That of its own triangles if they are of an evolved object, else resampled; also if the own one
    is clearly higher, as by noise, or much lower, as on a regular grid. Errors are of `complexity`.
    """
    resampled = resampled_complexity(mesh, bins)
    if not _is_of_voxels(mesh):
        return resampled
    own = complexity(mesh, bins)
    return own if REGULAR * resampled < own < resampled + NOISE else resampled


def _is_of_voxels(mesh: trimesh.Trimesh) -> bool:
    """Whether triangles have the size and shape that marching cubes and smoothing give them."""
    spacing = np.sqrt(mesh.area / len(mesh.vertices)) * VOXELS / np.max(mesh.extents)
    angles = np.sort(mesh.face_angles, axis=1)
    halves = (np.abs(angles[:, 2] - np.pi / 2) < 0.2) & (np.abs(angles[:, 0] - np.pi / 4) < 0.17)
    return bool(OWN_SPACING[0] < spacing < OWN_SPACING[1] and np.mean(halves) > MIN_HALF_SQUARES)


def resampled_complexity(mesh: trimesh.Trimesh, bins: int = BINS) -> float:
    """Complexity of the voxels with the closest smoothed surface; of the mesh without any."""
    check_mesh(mesh)
    closest = closest_voxels(FitTarget(mesh))
    return complexity(closest.surface if closest else mesh, bins)


def closest_voxels(target: FitTarget) -> Fit | None:
    """The voxels that a mesh was made from, or else close ones, 25 a side; None if none fits."""
    upright = np.eye(3)
    best = _search(target, upright, SIDES)
    if best and best.deviation > FAIR:
        low, high = VOXELS * np.array(DENSITY) / target.spacing
        few = np.arange(max(SMALLEST, low), min(SIDES[0], high), 0.2)
        other = _search(target, upright, few, 8)
        if other and other.size < best.size and other.deviation < CLEARLY * best.deviation:
            best = other
    if best is None or best.deviation > FAIR:
        frame = _face_axes(target)
        turned = [] if np.allclose(frame, upright, atol=1e-3) else [_search(target, frame, SIDES)]
        best = min(filter(None, [best, *turned]), key=_deviation, default=None)
    return best


def _search(target: FitTarget, frame: Floats, sides: Floats, most: int = 3) -> Fit | None:
    """The best fit on grids of a frame with so many voxels; `most` are improved if none is good."""
    turn = not np.array_equal(frame, np.eye(3))
    starts = []
    for number, grids in enumerate(_grids(target, frame, sides)):
        scores = [deviation(target, grid, SCORED) for grid in grids]
        starts.append((min(scores), number, grids[int(np.argmin(scores))]))
    fits: list[Fit] = []
    for _, _, grid in sorted(starts, key=lambda start: start[:2]):
        fitted = fit(target, grid, 2)
        fits += [fitted] if fitted else []
        if fits and fits[-1].deviation < GOOD:
            break
    good = [each for each in fits if each.deviation < GOOD]
    promising = good or sorted(fits, key=_deviation)[:most]
    refined = [_refined(target, each, 1, 2, turn) for each in promising]
    return _refined(target, min(refined, key=_deviation), 3, 6, turn) if refined else None


def _refined(target: FitTarget, best: Fit, times: int, rounds: int, turn: bool) -> Fit:
    """A fit on grids that are moved as long as that brings the surface closer."""
    for _ in range(times):
        other = fit(target, aligned(target, best, turn), rounds)
        if other is None or other.size >= best.size:
            return best
        best = other
    return best


def _grids(target: FitTarget, frame: Floats, sides: Floats) -> Iterator[list[Grid]]:
    """For each pitch, grids about the middle of the box, or with planes where most faces lie."""
    box = target.vertices @ frame.T
    low, high = box.min(axis=0), box.max(axis=0)
    lengths, middle = high - low, (low + high) / 2
    flat = target.normals @ frame.T, target.points @ frame.T
    for side in sides:
        pitch = lengths.max() / side
        between = _planes(*flat, pitch)
        odd = (side >= SIDES[0]) & (lengths > 0.97 * lengths.max())  # 25 cubes
        options = [
            (center + pitch / 2,) if known else (center + pitch / 2, center)
            for center, known in zip(middle, odd, strict=True)
        ]
        planes = [np.array(each) for each in product(*options)]
        planes += [between, np.where(odd, middle + pitch / 2, between)]
        yield [Grid.around(target, frame, pitch, plane) for plane in planes]


def _planes(normals: Floats, positions: Floats, pitch: float) -> Floats:
    """Where planes one pitch apart meet the most faces along each axis, (3,)."""
    phases = []
    for along, where in zip(normals.T, positions.T, strict=True):
        flat = np.abs(along) > FLAT
        turns = np.exp(-2j * np.pi * where[flat] / pitch)
        phases.append(np.angle(np.sum(turns * (np.abs(along[flat]) - FLAT))))
    return -np.array(phases) * pitch / (2 * np.pi)


def _face_axes(target: FitTarget) -> Floats:
    """Three axes at right angles that most of the area follows, as rows."""
    best, most = np.eye(3), -1.0
    for start in _STARTS:
        frame = start
        for _ in range(TURNS):
            cubes = (target.face_normals @ frame.T) ** 3 * target.areas[:, None]
            left, _, right = np.linalg.svd(np.einsum("ni,nj->ij", cubes, target.face_normals))
            frame = left @ right
        followed = float(np.sum((target.face_normals @ frame.T) ** 4 * target.areas[:, None]))
        if followed > most * (1 + 1e-6):
            best, most = frame, followed
    return best
