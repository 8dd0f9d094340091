"""Mass properties of solids of even density."""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray


class MassProperties(NamedTuple):
    """Of a solid: m3, m2, m, kg and kg m2.

    Attributes:
        volume: Volume.
        area: Surface area.
        com: Centre of mass, (3,).
        mass: Mass.
        inertia: Inertia tensor about the centre of mass, along the axes of the mesh, (3, 3).
    """

    volume: float
    area: float
    com: NDArray[np.float64]
    mass: float
    inertia: NDArray[np.float64]


def mass_properties(mesh: trimesh.Trimesh, density: float) -> MassProperties:
    """Exact integrals over the solid within a closed surface.

    They are taken about the middle of the box, in units of its longest side: far from the
    origin, or for millimetre-sized objects, digits would cancel.

    Args:
        mesh: A closed surface wound outwards, metres.
        density: kg/m3.

    Source: trimesh, after Eberly, Polyhedral Mass Properties, 2002.
    """
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
