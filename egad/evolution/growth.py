"""Genomes -> solids -> smooth meshes, at any resolution."""

import numpy as np
import trimesh

from egad._util.parameters import check_count
from egad.errors import RejectedError, UserError
from egad.evolution import constraints
from egad.evolution.constraints import UNBOUND, Rules
from egad.evolution.genome import Row
from egad.evolution.parameters import COARSEST, FINEST, Shape
from egad.evolution.query import query
from egad.evolution.voxels import Solid, unpack
from egad.geometry import Smoothing, in_single_precision, voxel_surface

SAME = 0.95  # least overlap of regrown voxels with those of an archive


def grow(
    genome: Row, resolution: int, threshold: float = Shape().threshold, rules: Rules = UNBOUND
) -> Solid:
    """The solid of a genome, (r, r, r), or `RejectedError` if it is empty or against the rules."""
    return constraints.solid(query(genome, resolution, rules.symmetry), threshold, rules)


def genome_mesh(
    genome: Row, resolution: int, *, shape: Shape | None = None, rules: Rules = UNBOUND
) -> trimesh.Trimesh:
    """The mesh that a genome describes, at any resolution.

    Every step is the same as in evolution: hidden holes are filled, parts thinner than three voxels
    are removed, the largest body is kept, and its surface is smoothed by the same number of rounds
    and scaled to the same longest side. So a finer grid keeps thinner parts and smooths less.
    Coordinates are rounded to single precision, so that all mesh formats hold them.

    Args:
        genome: As `EvolvedObject.genome`.
        resolution: Voxels along each side of the cube, 8 to 200.
        shape: Threshold, smoothing and size; those of the released objects by default.
        rules: Constraints at this resolution.

    Raises:
        UserError: The resolution is out of range.
        RejectedError: Nothing is left at this resolution, or what is left is against the rules.
    """
    shape = shape or Shape()
    check_resolution(resolution)
    return in_single_precision(surface(grow(genome, resolution, shape.threshold, rules), shape))


def check_resolution(resolution: int) -> None:
    """Raise UserError if it is not a whole number from 8 to 200."""
    if not COARSEST <= check_count("resolution", resolution) <= FINEST:
        raise UserError(f"resolution is {resolution}; allowed: {COARSEST} to {FINEST}")


def check_regrown(genome: Row, voxels: Solid, threshold: float, rules: Rules = UNBOUND) -> None:
    """Raise `UserError` if a genome describes other voxels than an archive has, but for a few."""
    grown = grow(genome, len(voxels), threshold, rules)
    if np.count_nonzero(grown & voxels) < SAME * np.count_nonzero(grown | voxels):
        raise UserError(
            "its genome does not describe its voxels, so it was evolved under constraints; give "
            "the configuration with them: egad export-meshes ARCHIVE --resolution N --config FILE"
        )


def packed_surface(packed: bytes, shape: Shape) -> trimesh.Trimesh:
    """The surface of voxels as archives keep them; `RejectedError` if none is solid."""
    voxels = unpack(packed, shape.resolution)
    if not voxels.any():
        raise RejectedError("no solid voxel")
    return surface(voxels, shape)


def surface(voxels: Solid, shape: Shape) -> trimesh.Trimesh:
    """The smoothed surface of voxels (EGAD, III-B), in metres, its box centered on the origin."""
    smoothing = Smoothing(shape.smoothing_iterations, shape.smoothing_alpha, shape.smoothing_beta)
    _, mesh = voxel_surface(voxels, smoothing)
    low, high = mesh.bounds
    mesh.vertices = (mesh.vertices - (low + high) / 2) * (shape.longest_side / (high - low).max())
    return mesh
