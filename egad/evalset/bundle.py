"""An object as simulators need it: convex parts, mass properties, poses at rest."""

from dataclasses import dataclass

import numpy as np
import trimesh

from egad.errors import RejectedError
from egad.settings import Bundle
from egad.shapes.coacd_parts import coacd_parts
from egad.shapes.convex import convex_parts, joined
from egad.shapes.deviation import largest_deviation
from egad.shapes.manifold import is_solid, to_mesh, to_solid
from egad.shapes.mass import MassProperties, mass_properties
from egad.shapes.poses import StablePose, grouped, stable_poses

LEAST_PROBABILITY = 0.001  # of the poses that are listed
SAME_POSE = np.radians(5)


@dataclass(frozen=True)
class Bundled:
    """An object in the frame of its mesh, metres.

    Attributes:
        mesh: The surface, wound outwards.
        parts: Convex meshes that stand for it in contacts.
        physics: Mass properties of the solid within the surface, not of the parts.
        poses: How it can rest on a table: 5 degrees apart, and at least 0.1 % probable.
        volume_error: Volume of the union of the parts / volume of the object - 1.
        deviation: Largest distance of what sticks out of the object from its surface.
    """

    mesh: trimesh.Trimesh
    parts: tuple[trimesh.Trimesh, ...]
    physics: MassProperties
    poses: tuple[StablePose, ...]
    volume_error: float
    deviation: float


def bundled(mesh: trimesh.Trimesh, density: float, settings: Bundle) -> Bundled:
    """Make an object of uniform density ready for simulators.

    Args:
        mesh: A closed surface in metres, wound either way.
        density: kg/m3.
        settings: How the parts are made.

    Raises:
        RejectedError: The mesh does not bound a solid, or has no such parts.
        UserError: CoACD is wanted and not installed.
    """
    solid = _outward(mesh)
    if settings.method == "coacd":
        parts = coacd_parts(solid, settings.coacd_threshold, settings.max_parts)
    else:
        parts = convex_parts(solid, settings.max_parts, settings.volume_error)
    physics = mass_properties(solid, density)
    together = joined(parts)
    beyond = together - to_solid(solid.vertices, solid.faces)  # parts meet inside, with fine cracks
    poses = grouped(stable_poses(solid, physics.com), SAME_POSE)
    return Bundled(
        mesh=solid,
        parts=tuple(parts),
        physics=physics,
        poses=tuple(pose for pose in poses if pose.probability >= LEAST_PROBABILITY),
        volume_error=float(together.volume()) / physics.volume - 1,
        deviation=0.0 if beyond.is_empty() else largest_deviation(to_mesh(beyond), solid),
    )


def _outward(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """The mesh wound outwards.

    Raises:
        RejectedError: It does not bound a solid.
    """
    found = mesh.copy()
    if found.volume < 0:
        found.invert()
    solid = to_solid(found.vertices, found.faces)
    if not is_solid(solid) or not solid.volume() > 0:
        raise RejectedError("the surface does not bound a solid")
    return found
