"""An object as the physics engine needs it: convex parts, mass and principal inertia."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import trimesh

from egad._util.arrays import Floats
from egad.geometry import Bundle, MassProperties, Material
from egad.grippers import Gripper
from egad.objects import NamedMesh, scaled_solid
from egad.sim.simulation_objects import make_simulation_object

# kg; PyBullet's solver does not converge for lighter bodies under large grip forces:
# studies/engines/README.md
MIN_MASS = 0.05


@dataclass(frozen=True)
class Model:
    """An object in its principal frame: origin in the center of mass, principal axes of inertia."""

    mesh: trimesh.Trimesh  # the true surface, for depth images. Metres
    parts: tuple[trimesh.Trimesh, ...]  # convex meshes that represent it in contacts. Metres
    mass: float  # kilograms, at least 50 g
    solid_mass: float  # mass of the solid, which may be less, kilograms
    inertia: Floats  # (3,) principal moments about the center of mass, kg m2
    volume_error: float  # volume of the parts / volume of the mesh - 1
    # (4, 4) transform from the frame that the object was given in, with its scale
    to_principal: Floats

    def scaled(self, factor: float) -> "Model":
        """The same object at `factor` times its size, of the same density, but at least 50 g."""
        solid_mass = self.solid_mass * factor**3
        mass = max(solid_mass, MIN_MASS)
        to_principal = np.diag([factor, factor, factor, 1.0]) @ self.to_principal
        return replace(
            self,
            mesh=self.mesh.copy().apply_scale(factor),
            parts=tuple(part.copy().apply_scale(factor) for part in self.parts),
            mass=mass,
            solid_mass=solid_mass,
            inertia=self.inertia * (mass / self.mass) * factor**2,
            to_principal=to_principal,
        )


def model_of(
    mesh: trimesh.Trimesh,
    parts: Sequence[trimesh.Trimesh],
    physics: MassProperties,
    volume_error: float,
) -> Model:
    """Model an object of the simulation bundle, of at least 50 g, as in BURG."""
    moments, to_principal = principal_frame(physics)
    return Model(
        mesh=mesh.copy().apply_transform(to_principal),
        parts=tuple(part.copy().apply_transform(to_principal) for part in parts),
        mass=max(physics.mass, MIN_MASS),
        solid_mass=physics.mass,
        inertia=moments,
        volume_error=volume_error,
        to_principal=to_principal,
    )


def principal_frame(physics: MassProperties) -> tuple[Floats, Floats]:
    """Principal moments (3,), kg m2, of at least 50 g, and the frame, as `Model.to_principal`."""
    mass = max(physics.mass, MIN_MASS)
    moments, axes = np.linalg.eigh(physics.inertia * (mass / physics.mass))
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])  # right-handed
    to_principal = np.eye(4)
    to_principal[:3, :3] = axes.T
    to_principal[:3, 3] = -axes.T @ physics.com
    return moments, to_principal


def build(mesh: trimesh.Trimesh, density: float, settings: Bundle, name: str = "the mesh") -> Model:
    """Model any object of uniform density, kg/m3; RejectedError if it is no solid; PartsWarning."""
    made = make_simulation_object(mesh, density, settings, name)
    return model_of(made.mesh, made.parts, made.physics, made.volume_error)


def simulated(target: NamedMesh, gripper: Gripper, rule: str) -> tuple[trimesh.Trimesh, Model]:
    """The mesh of an object as a gripper grasps it, and its default model; errors as in `build`."""
    mesh = scaled_solid(target, gripper, rule)
    return mesh, build(mesh, Material().density, Bundle(), target.label)
