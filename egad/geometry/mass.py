"""Mass properties of solids of uniform density."""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from egad._util.arguments import check_array
from egad._util.arrays import Floats
from egad._util.kernels import kernel
from egad.geometry.checks import check_solid
from egad.geometry.rays import bounding_box


class MassProperties(NamedTuple):
    """Mass properties of a solid: m3, m2, m, kg and kg m2."""

    volume: float
    area: float
    com: Floats  # center of mass, (3,)
    mass: float
    # inertia tensor about the center of mass, along the axes of the mesh, (3, 3)
    inertia: Floats


def mass_properties(mesh: trimesh.Trimesh, density: float) -> MassProperties:
    """Exact integrals over the solid in a closed surface, metres and kg/m3; or `RejectedError`.

    About the middle of the box, in its longest side, lest digits cancel. Source: Eberly 2002.
    """
    check_solid(mesh)
    low, high = np.asarray(mesh.bounds)
    middle, size = (low + high) / 2, float((high - low).max())
    unit = trimesh.triangles.mass_properties((mesh.triangles - middle) / size)
    volume = float(unit["volume"]) * size**3
    return MassProperties(
        volume=volume,
        area=float(mesh.area),
        com=middle + np.asarray(unit["center_mass"]) * size,
        mass=density * volume,
        inertia=density * np.asarray(unit["inertia"]) * size**5,
    )


def center_or_given(mesh: trimesh.Trimesh, given: ArrayLike | None) -> Floats:
    """The center of mass that is given, or that of the solid."""
    if given is None:
        return mass_properties(mesh, 1.0).com
    return check_array("center_of_mass", given, (3,), "3 finite numbers")


def center_of_mass(mesh: trimesh.Trimesh) -> Floats:
    """The centroid of the volume, quickly; of the surface if the former is outside its box."""
    triangles = np.asarray(mesh.vertices)[mesh.faces]
    center = _volume_centroid(triangles)
    low, high = bounding_box(triangles)
    inside = bool(np.all((center >= low) & (center <= high)))  # False for NaN
    return center if inside else np.asarray(mesh.centroid)


@kernel()
def _volume_centroid(triangles: Floats) -> Floats:
    """Centroid of a solid from triangles (n, 3, 3), without the inertia tensor, for speed."""
    moment, volume = np.zeros(3), 0.0
    a, b, c = np.empty(3), np.empty(3), np.empty(3)
    for i in range(len(triangles)):
        for k in range(3):  # from the first corner, for precision far from the origin
            start = triangles[0, 0, k]
            a[k], b[k] = triangles[i, 0, k] - start, triangles[i, 1, k] - start
            c[k] = triangles[i, 2, k] - start
        six_volumes = 0.0
        for k in range(3):
            m, n = (k + 1) % 3, (k + 2) % 3
            six_volumes += a[k] * (b[m] * c[n] - b[n] * c[m])
        volume += six_volumes
        for k in range(3):
            moment[k] += six_volumes * (a[k] + b[k] + c[k])
    center: Floats = triangles[0, 0] + moment / (4 * volume)
    return center
