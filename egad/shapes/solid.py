"""Any mesh -> the solid that is measured, with its mass properties."""

from typing import NamedTuple

import trimesh

from egad.errors import RejectedError
from egad.settings import Material, Postprocess
from egad.shapes.mass import MassProperties, mass_properties
from egad.shapes.repair import repair


class Body(NamedTuple):
    """A closed mesh, whether repair changed it, and its mass properties."""

    mesh: trimesh.Trimesh
    repaired: bool
    mass: MassProperties


def body(mesh: trimesh.Trimesh, material: Material, limits: Postprocess) -> Body:
    """Repair a mesh and weigh it.

    Args:
        mesh: In metres.
        material: Density.
        limits: The least volume that an object may have.

    Raises:
        RejectedError: The mesh cannot be repaired, or is too small.
    """
    repaired = repair(mesh)
    mass = mass_properties(repaired.mesh, material.density)
    if mass.volume < limits.min_volume:
        raise RejectedError(
            f"volume of {mass.volume:.3g} m3 is below {limits.min_volume:.3g} m3: "
            "is the unit of the mesh right?"
        )
    return Body(repaired.mesh, repaired.changed, mass)
