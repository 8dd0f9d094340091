"""Mass properties of solids of uniform density; repair and weigh any mesh."""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.errors import RejectedError
from egad.geometry.checks import check_solid
from egad.geometry.parameters import SHELL_THICKNESS, OpenSurfaces
from egad.geometry.repair import Repaired, repair_for_files


class MassProperties(NamedTuple):
    """Mass properties of a solid: m3, m2, m, kg and kg m2.

    Attributes:
        volume: Volume.
        area: Surface area.
        com: Center of mass, (3,).
        mass: Mass.
        inertia: Inertia tensor about the center of mass, along the axes of the mesh, (3, 3).
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

    Raises:
        RejectedError: The mesh is not closed or bounds no volume.
        UserError: It is not a mesh.

    Source: trimesh, after Eberly, Polyhedral Mass Properties, 2002.
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


class Body(NamedTuple):
    """A repaired mesh and its mass properties."""

    repaired: Repaired
    mass: MassProperties


def repair_and_weigh(
    mesh: trimesh.Trimesh,
    density: float,
    min_volume: float = 0.0,
    open_surfaces: OpenSurfaces = "reject",
    thickness: float = SHELL_THICKNESS,
) -> Body:
    """Repair a mesh, round its coordinates to single precision, and weigh it.

    Args:
        mesh: In metres.
        density: kg/m3.
        min_volume: The least volume that an object may have, m3.
        open_surfaces: See `egad.geometry.repair.repair`.
        thickness: Wall thickness of the shells that open surfaces become, metres.

    Raises:
        RejectedError: The mesh cannot be repaired, or is too small.
    """
    repaired = repair_for_files(mesh, open_surfaces, thickness)
    mass = mass_properties(repaired.mesh, density)
    if mass.volume < min_volume:
        raise RejectedError(
            f"volume of {mass.volume:.3g} m3 is below {min_volume:.3g} m3: "
            "is the unit of the mesh right?"
        )
    return Body(repaired, mass)
