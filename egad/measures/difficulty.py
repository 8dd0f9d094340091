"""Grasp difficulty: how good the better grasps of an object are.

The rules are EGAD's (Morrison, Corke and Leitner, RA-L 2020): many antipodal grasps are sampled on
the object scaled to the gripper, and a percentile of their quality is taken.
"""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from scipy.special import betainc

from egad.errors import RejectedError
from egad.geometry import RayCaster, check_mesh
from egad.grasps import ContactPairs, ferrari_canny, robust_ferrari_canny, sample_contacts
from egad.measures.parameters import MeasureParameters

Floats = NDArray[np.float64]
FLAT = 1e-6  # smallest side over longest: below this a surface has no inside


class GraspDifficulty(NamedTuple):
    """How hard an object is to grasp.

    Attributes:
        value: Percentile of the quality of sampled grasps.
        std: Standard error of that, as if the grasps were independent of each other.
        grasps: How many it was taken from: fewer than wanted if the sampler did not find more.
    """

    value: float
    std: float
    grasps: int


def difficulty(
    mesh: trimesh.Trimesh,
    settings: MeasureParameters,
    grasps: int,
    rng: np.random.Generator,
    com: Floats | None = None,
) -> GraspDifficulty:
    """A percentile of the quality of sampled grasps: high values are easy objects.

    A copy of the mesh is measured: turned until its principal axes (of the vertices) are the
    coordinate axes, then scaled until its smallest side is `side_fraction` of the opening. Grasps
    without quality count as zeros.

    Args:
        mesh: The object, of any size, its triangles winding outwards.
        settings: Gripper, metric, percentile, and how grasps are sampled and rated.
        grasps: Grasps to sample.
        rng: Where chance comes from.
        com: Center of mass in the frame of the mesh; else the centroid of the volume.

    Raises:
        RejectedError: There is no grasp, or the mesh is empty, flat or not finite.
        UserError: It is not a mesh.
    """
    check_mesh(mesh)
    opening = settings.gripper.opening
    place = _alignment(np.asarray(mesh.vertices), settings.difficulty.side_fraction * opening)
    scaled = trimesh.Trimesh(_apply(place, mesh.vertices), mesh.faces, process=False)
    center = _apply(place, center_of_mass(mesh) if com is None else com)
    caster = RayCaster(scaled)
    found, tally = sample_contacts(caster, opening, grasps, settings.sampling, rng)
    if len(found) == 0:
        raise RejectedError(f"no grasp ({tally})")
    qualities = _qualities(caster, found, center, settings, rng)
    percent = settings.difficulty.percentile
    return GraspDifficulty(
        percentile(qualities, percent), percentile_std(qualities, percent), len(found)
    )


def _qualities(
    caster: RayCaster,
    grasps: ContactPairs,
    com: Floats,
    settings: MeasureParameters,
    rng: np.random.Generator,
) -> Floats:
    """Quality of each grasp by the metric of the settings."""
    if settings.difficulty.metric == "nominal" or settings.robust is None:
        rated: Floats = ferrari_canny(
            grasps.points, grasps.normals, grasps.axes, com, **settings.quality.model_dump()
        )
        return rated
    mean, _, _ = robust_ferrari_canny(
        caster,
        grasps,
        com,
        settings.gripper.opening,
        quality=settings.quality,
        robust=settings.robust,
        rng=rng,
    )
    return mean


def percentile(values: Floats, percent: float) -> float:
    """The value at index n * percent / 100 of the ascending values: no interpolation."""
    index = min(int(len(values) * percent / 100), len(values) - 1)
    return float(np.sort(values)[index])


def percentile_std(values: Floats, percent: float) -> float:
    """Standard error of a sample percentile of n independent values.

    Source: Maritz and Jarrett, JASA 73 (1978).
    """
    count = len(values)
    m = min(int(count * percent / 100), count - 1) + 1  # the percentile is the m-th smallest value
    weights = np.diff(betainc(m, count - m + 1, np.arange(count + 1) / count))
    ordered = np.sort(values)
    mean = weights @ ordered
    return float(np.sqrt(weights @ (ordered - mean) ** 2))


def center_of_mass(mesh: trimesh.Trimesh) -> Floats:
    """The centroid of the volume; that of the surface where the volume has none within bounds."""
    center = _volume_centroid(np.asarray(mesh.triangles), np.asarray(mesh.triangles_cross))
    low, high = np.asarray(mesh.bounds)
    inside = bool(np.all((center >= low) & (center <= high)))  # False for NaN
    return center if inside else np.asarray(mesh.centroid)


def _volume_centroid(triangles: Floats, normals: Floats) -> Floats:
    """The centroid of a solid from its (n, 3, 3) triangles and their scaled normals, (n, 3).

    The same as `trimesh.Trimesh.center_mass`, without the inertia tensor that costs most of it.
    """
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    total = a + b + c
    squares = a**2 + b**2 + a * b + c * total
    volume = np.sum(normals[:, 0] * total[:, 0]) / 6
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.sum((normals * squares).T.copy(), axis=1) / 24 / volume)


def _alignment(vertices: Floats, side: float) -> tuple[Floats, Floats]:
    """The middle of the vertices, and what turns and scales points about it.

    Principal axes become coordinate axes, the longest z, and the smallest side becomes `side`.
    """
    middle = vertices.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov(vertices - middle, rowvar=False))
    axes[:, 0] *= np.sign(np.linalg.det(axes))  # a rotation, no mirror
    extents = np.ptp((vertices - middle) @ axes, axis=0)
    if extents.min() <= FLAT * extents.max():
        raise RejectedError("flat")
    return middle, axes * (side / extents.min())


def _apply(place: tuple[Floats, Floats], points: ArrayLike) -> Floats:
    middle, matrix = place
    return np.asarray((np.asarray(points, dtype=float) - middle) @ matrix)
