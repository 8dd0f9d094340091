"""The constraints on all shapes of a search, with the meshes that they name."""

from pathlib import Path

import trimesh

from egad.errors import RejectedError, UserError
from egad.evolution.constraints import Rules, build_rules
from egad.evolution.parameters import EvolutionParameters
from egad.geometry.repair import repair
from egad.io import read_mesh


def rules_of(settings: EvolutionParameters, resolution: int | None = None) -> Rules:
    """The constraints on all shapes.

    Args:
        settings: All constraints.
        resolution: Voxels along each side of the cube; None: as in evolution.

    Raises:
        UserError: The constraints leave no voxel to grow in, or a mesh cannot be used.
    """
    return build_rules(
        resolution or settings.shape.resolution,
        mesh_of,
        envelope=settings.envelope,
        keep_solid=settings.keep_solid,
        hole=settings.hole,
        symmetry=settings.symmetry,
        limits=settings.limits,
    )


def mesh_of(path: str) -> trimesh.Trimesh:
    """The closed mesh in a file that a region names; `UserError` if it cannot be used."""
    try:
        mesh = read_mesh(Path(path), "m")
        closed = repair(mesh).mesh
    except RejectedError as reason:
        raise UserError(f"the mesh {path} of a region cannot be used: {reason}") from reason
    if mesh.body_count > 1:
        raise UserError(f"the mesh {path} of a region has {mesh.body_count} parts; one is allowed")
    return closed
