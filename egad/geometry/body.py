"""Repair and weigh any mesh."""

from typing import NamedTuple

import trimesh

from egad.errors import RejectedError
from egad.geometry.mass import MassProperties, mass_properties
from egad.geometry.parameters import SHELL_THICKNESS, OpenSurfaces
from egad.geometry.repair import Repaired, repair_for_files


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
    """Repair a mesh for files and weigh it, kg/m3; `RejectedError` if it is below `min_volume`."""
    repaired = repair_for_files(mesh, open_surfaces, thickness)
    mass = mass_properties(repaired.mesh, density)
    if mass.volume < min_volume:
        raise RejectedError(
            f"volume of {mass.volume:.3g} m3 is below {min_volume:.3g} m3: "
            "is the unit of the mesh right?"
        )
    return Body(repaired, mass)
