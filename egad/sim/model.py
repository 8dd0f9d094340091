"""An object as the physics engine needs it: convex parts, mass and principal inertia."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import trimesh

from egad._util.arrays import Floats, dot_products
from egad.geometry import Bundle, MassProperties, Material
from egad.grippers import Gripper
from egad.objects import NamedMesh, scaled_solid
from egad.sim.simulation_objects import make_simulation_object

# kg; PyBullet's solver does not converge for lighter bodies under large grip forces:
# studies/engines/README.md
MIN_MASS = 0.05
SWEEPS = 10  # of Jacobi rotations; four or five are enough for double precision
NEGLIGIBLE = 1e-30  # of the trace: an entry off the diagonal that changes no bit


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
        mesh=_moved(mesh, to_principal),
        parts=tuple(_moved(part, to_principal) for part in parts),
        mass=max(physics.mass, MIN_MASS),
        solid_mass=physics.mass,
        inertia=moments,
        volume_error=volume_error,
        to_principal=to_principal,
    )


def principal_frame(physics: MassProperties) -> tuple[Floats, Floats]:
    """Principal moments (3,), kg m2, of at least 50 g, and the frame, as `Model.to_principal`."""
    mass = max(physics.mass, MIN_MASS)
    moments, axes = _principal_axes(physics.inertia * (mass / physics.mass))
    to_principal = np.eye(4)
    to_principal[:3, :3] = axes
    to_principal[:3, 3] = -dot_products(axes, physics.com[None])[:, 0]
    return moments, to_principal


def _principal_axes(inertia: Floats) -> tuple[Floats, Floats]:
    """Moments, ascending, and axes as rows, by Jacobi rotations: LAPACK's bits differ."""
    turned, axes = inertia.copy(), np.eye(3)
    for i, j in SWEEPS * ((0, 1), (0, 2), (1, 2)):
        if abs(turned[i, j]) <= NEGLIGIBLE * turned.trace():
            continue
        ratio = (turned[j, j] - turned[i, i]) / (2 * turned[i, j])
        tangent = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(ratio * ratio + 1))
        cosine = 1 / math.sqrt(tangent * tangent + 1)
        for matrix in (turned, turned.T, axes):
            first, second = matrix[i].copy(), matrix[j].copy()
            matrix[i] = cosine * (first - tangent * second)
            matrix[j] = cosine * (second + tangent * first)
        turned[i, j] = turned[j, i] = 0.0
    order = np.argsort(turned.diagonal(), kind="stable")
    axes = axes[order]
    axes *= np.sign(axes[range(3), np.abs(axes).argmax(axis=1)])[:, None]
    axes[2] = np.cross(axes[0], axes[1])  # right-handed
    return turned.diagonal()[order], axes


def moved(points: Floats, transform: Floats) -> Floats:
    """Points (n, 3) after a (4, 4) transform, with the same bits on every processor."""
    return dot_products(points, transform[:3, :3]) + transform[:3, 3]


def _moved(mesh: trimesh.Trimesh, transform: Floats) -> trimesh.Trimesh:
    return trimesh.Trimesh(moved(mesh.vertices, transform), mesh.faces, process=False)


def build(mesh: trimesh.Trimesh, density: float, settings: Bundle, name: str = "the mesh") -> Model:
    """Model any object of uniform density, kg/m3; RejectedError if it is no solid; PartsWarning."""
    made = make_simulation_object(mesh, density, settings, name)
    return model_of(made.mesh, made.parts, made.physics, made.volume_error)


def simulated(target: NamedMesh, gripper: Gripper, rule: str) -> tuple[trimesh.Trimesh, Model]:
    """The mesh of an object as a gripper grasps it, and its default model; errors as in `build`."""
    mesh = scaled_solid(target, gripper, rule)
    return mesh, build(mesh, Material().density, Bundle(), target.label)
