"""What every shape must obey: envelope, part, hole, symmetry and limits (ours)."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy import ndimage

from egad.errors import RejectedError, UserError
from egad.settings import Limits, Region, Symmetry
from egad.shapes import voxels
from egad.shapes.primitives import region_voxels
from egad.shapes.symmetry import AXES, is_whole
from egad.shapes.voxels import Solid
from egad.stage_settings import Evolve

Reader = Callable[[str], trimesh.Trimesh]


@dataclass(frozen=True)
class Rules:
    """What every shape must obey. By default nothing.

    Attributes:
        allowed: Voxels that may be solid; None: all.
        part: Voxels that must be solid, all of them allowed; None: none.
        symmetry: Mirrors and turn.
        limits: Aspect ratio and volume.
    """

    allowed: Solid | None = None
    part: Solid | None = None
    symmetry: Symmetry = field(default_factory=Symmetry)
    limits: Limits = field(default_factory=Limits)

    def clip(self, solid: Solid) -> Solid:
        """The solid with the part, and without what is not allowed."""
        joined = solid if self.part is None else solid | self.part
        return joined if self.allowed is None else joined & self.allowed


UNBOUND = Rules()


def rules_of(settings: Evolve, read: Reader) -> Rules:
    """The rules that a configuration asks for.

    Args:
        settings: What evolution reads.
        read: Gives the closed mesh of a file, for regions of that kind.

    Raises:
        UserError: Nothing could grow by these rules, or a mesh cannot be used.
    """

    def grid(region: Region) -> Solid | None:
        if region.kind == "none":
            return None
        mesh = read(region.mesh) if region.kind == "mesh" else None
        return region_voxels(region, settings.shape.resolution, mesh)

    mirror = settings.symmetry.mirror
    envelope, part, hole = map(grid, (settings.envelope, settings.part, settings.hole))
    shape = (settings.shape.resolution,) * 3
    void = np.zeros(shape, dtype=bool) if hole is None else with_images(hole, mirror)
    outside = np.zeros(shape, dtype=bool) if envelope is None else with_images(~envelope, mirror)
    kept = np.zeros(shape, dtype=bool) if part is None else with_images(part, mirror) & ~void
    allowed = (kept | ~outside) & ~void
    if part is not None and not kept.any():
        raise UserError("part: no voxel of it lies outside the hole")
    if not allowed.any():
        raise UserError("envelope and hole leave no voxel of the cube to grow in")
    return Rules(
        None if allowed.all() else allowed,
        None if part is None else kept,
        settings.symmetry,
        settings.limits,
    )


def with_images(solid: Solid, mirror: tuple[str, ...]) -> Solid:
    """A solid joined with its mirror images."""
    for axis in mirror:
        solid = solid | np.flip(solid, AXES.index(axis))
    return solid


def solid(output: NDArray[np.float32], threshold: float, rules: Rules) -> Solid:
    """The one solid body that the output of a network describes within the rules.

    As `egad.shapes.voxels.solid`; the part is added and what is not allowed cut away both before
    hidden voxels are filled and after thin parts are removed.

    Returns:
        Boolean array of its shape, not empty.

    Raises:
        RejectedError: Nothing is left, or what is left is against the rules.
    """
    if rules.allowed is None and rules.part is None:
        body = voxels.solid(output, threshold)
    else:
        filled = voxels.fill_orthographic(rules.clip(output > threshold))
        opened = rules.clip(ndimage.binary_opening(filled))
        body = _without_voids(voxels.largest_body(opened), rules)
    if not body.any():
        raise RejectedError("empty")
    if rules.part is not None and not body[rules.part].all():
        raise RejectedError("apart from its part")
    if not is_whole(body, rules.symmetry):
        raise RejectedError("one of several mirror or turned images")
    _check_limits(body, rules.limits)
    return body


def _without_voids(body: Solid, rules: Rules) -> Solid:
    """A body with its voids filled; one that must stay empty would be filled by repair later."""
    full: Solid = ndimage.binary_fill_holes(body)
    if rules.allowed is not None and (full & ~rules.allowed).any():
        raise RejectedError("closed around what must stay empty")
    return full


def _check_limits(body: Solid, limits: Limits) -> None:
    if limits == UNBOUND.limits:
        return
    sides = box_sides(body)
    volume = int(body.sum())
    values = {
        "aspect ratio": (sides.max() / sides.min(), limits.aspect_ratio),
        "part of its box": (volume / sides.prod(), limits.box_part),
        "part of the cube": (volume / body.size, limits.cube_part),
    }
    for name, (value, (low, high)) in values.items():
        if not low <= value <= high:
            raise RejectedError(f"{name} out of limits ({value:.3g})")


def box_sides(body: Solid) -> NDArray[np.int64]:
    """Sides of the axis-aligned box of a body, in voxels, (3,)."""
    return np.asarray(np.ptp(np.argwhere(body), axis=0) + 1)
