"""An object as the physics engine needs it: convex parts, mass and principal inertia."""

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.shapes.convex import convex_parts, excess_volume
from egad.shapes.mass import mass_properties

Floats = NDArray[np.float64]

MIN_MASS = 0.05  # kg; contacts of lighter bodies with a strong hand are stiff and jitter


@dataclass(frozen=True)
class Model:
    """An object in its principal frame: origin in the centre of mass, axes those of inertia.

    Attributes:
        mesh: The true surface, for depth images. Metres.
        parts: Convex meshes that stand for it in contacts. Metres.
        mass: Kilograms.
        inertia: Principal moments about the centre of mass, (3,), kg m2.
        volume_error: Volume of the parts / volume of the mesh - 1.
        to_principal: (4, 4) transform from the frame that the object was given in.
    """

    mesh: trimesh.Trimesh
    parts: tuple[trimesh.Trimesh, ...]
    mass: float
    inertia: Floats
    volume_error: float
    to_principal: Floats


def build(mesh: trimesh.Trimesh, density: float, max_parts: int, volume_error: float) -> Model:
    """Model an object of uniform density (ours).

    An object lighter than 50 g gets that mass, spread as before: the least mass that BURG also
    simulates.

    Args:
        mesh: A closed surface, in metres.
        density: kg/m3.
        max_parts: Most convex parts.
        volume_error: Splitting into parts stops below this error.

    Raises:
        RejectedError: The mesh does not bound a solid, or has too many bodies.
    """
    parts = convex_parts(mesh, max_parts, volume_error)
    solid = mesh.copy()
    if solid.volume < 0:
        solid.invert()
    true = mass_properties(solid, density)
    mass = max(true.mass, MIN_MASS)
    moments, axes = np.linalg.eigh(true.inertia * (mass / true.mass))
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])  # right-handed
    to_principal = np.eye(4)
    to_principal[:3, :3] = axes.T
    to_principal[:3, 3] = -axes.T @ true.com
    error = excess_volume(parts, solid)
    return Model(
        mesh=solid.apply_transform(to_principal),
        parts=tuple(part.apply_transform(to_principal) for part in parts),
        mass=mass,
        inertia=moments,
        volume_error=error,
        to_principal=to_principal,
    )
