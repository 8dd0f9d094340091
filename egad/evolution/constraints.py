"""Constraints on shapes (ours): envelope, required solid, hole, symmetry, limits."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import trimesh
from scipy import ndimage

from egad._util.arrays import Floats, Ints, Singles
from egad.errors import RejectedError, UserError
from egad.evolution import voxels
from egad.evolution.parameters import EvolutionParameters, Limits, Region, Symmetry
from egad.evolution.voxels import Solid
from egad.geometry import RayCaster
from egad.geometry.repair import repair
from egad.io import read_mesh

AXES = "xyz"
EDGE = 1 + 1e-9  # a voxel whose middle lies on the edge belongs to the region


def folded(points: Singles, symmetry: Symmetry) -> Singles:
    """Where a network is queried in place of each point (3, n) within [-1, 1]: (3, n) float32.

    A mirror takes the absolute value of a coordinate; a rotation multiplies the angle about its
    axis by the fold, so neighbors stay neighbors and shapes may be twisted. With a mirror along the
    axis, all its rotations are mirrors, too. Mirror images become equal to the last bit.
    """
    found = points.astype(np.float64).round(6)  # so that -a and a have the same magnitude
    for axis in symmetry.mirror:
        found[AXES.index(axis)] = np.abs(found[AXES.index(axis)])
    if symmetry.fold > 1:
        first, second = across(symmetry.axis)
        radius = np.hypot(found[first], found[second])
        angle = symmetry.fold * np.arctan2(found[second], found[first])
        found[first], found[second] = radius * np.cos(angle), radius * np.sin(angle)
        for place in (first, second):
            if AXES[place] in symmetry.mirror:
                kept = first if place == first and symmetry.fold % 2 else second
                found[kept] = np.abs(found[kept])
    return found.astype(np.float32)


def across(axis: str) -> tuple[int, int]:
    """The two coordinates across an axis, in the order of a rotation about it."""
    place = AXES.index(axis)
    return (place + 1) % 3, (place + 2) % 3


def is_whole(voxels: Solid, symmetry: Symmetry) -> bool:
    """Whether a body is not one of several images of each other: each image covers half of it."""
    images = [np.flip(voxels, AXES.index(axis)) for axis in symmetry.mirror]
    if symmetry.fold > 1:
        images.append(turned(voxels, symmetry))
    return all(2 * np.count_nonzero(voxels & image) >= voxels.sum() for image in images)


def turned(voxels: Solid, symmetry: Symmetry) -> Solid:
    """A body rotated about the middle by one fold, by nearest voxels; those outside are dropped."""
    middle = (np.array(voxels.shape) - 1) / 2
    offsets = np.indices(voxels.shape).reshape(3, -1) - middle[:, None]
    first, second = across(symmetry.axis)
    cosine, sine = np.cos(2 * np.pi / symmetry.fold), np.sin(2 * np.pi / symmetry.fold)
    from_ = offsets.copy()
    from_[first] = cosine * offsets[first] + sine * offsets[second]
    from_[second] = cosine * offsets[second] - sine * offsets[first]
    index = np.rint(from_ + middle[:, None]).astype(np.int64)
    inside = np.all((index >= 0) & (index < np.array(voxels.shape)[:, None]), axis=0)
    image = np.zeros(voxels.size, dtype=bool)
    image[inside] = voxels[tuple(index[:, inside])]
    return image.reshape(voxels.shape)


def region_voxels(region: Region, resolution: int, mesh: trimesh.Trimesh | None = None) -> Solid:
    """The voxels, (r, r, r), whose middles lie in a region, which may be a mesh of any size."""
    points = voxel_middles(resolution) - np.array(region.center)
    if region.kind == "mesh":
        if mesh is None:
            raise UserError(f"the mesh {region.mesh} of a region was not read")
        low, high = np.asarray(mesh.bounds)
        scale = np.min(np.array(region.size) / (high - low))  # until its box fits into the region
        vertices = (np.asarray(mesh.vertices) - (low + high) / 2) * scale
        fitted = trimesh.Trimesh(vertices, mesh.faces, process=False)
        inside = RayCaster(fitted).contains(points)
    else:
        inside = _within_primitive(region, 2 * points / np.array(region.size))
    return inside.reshape((resolution,) * 3)


def voxel_middles(resolution: int) -> Floats:
    """(resolution^3, 3) in C order, in a cube with sides of 1 and its middle at 0."""
    indices = np.indices((resolution,) * 3).reshape(3, -1).T
    return np.asarray((indices + 0.5) / resolution - 0.5)


def _within_primitive(region: Region, scaled: Floats) -> Solid:
    """Which points lie in a region, given in halves of its sides from its middle."""
    if region.kind == "box":
        return np.asarray(np.abs(scaled).max(axis=1) <= EDGE)
    if region.kind == "ellipsoid":
        return np.asarray((scaled**2).sum(axis=1) <= EDGE)
    along = "xyz".index(region.axis)
    across = np.delete(scaled, along, axis=1)
    return np.asarray(((across**2).sum(axis=1) <= EDGE) & (np.abs(scaled[:, along]) <= EDGE))


@dataclass(frozen=True)
class Rules:
    """Constraints that every shape must obey; none by default."""

    allowed: Solid | None = None  # voxels that may be solid; None: all
    required: Solid | None = None  # voxels that must be solid, all of them allowed; None: none
    symmetry: Symmetry = field(default_factory=Symmetry)  # mirrors and rotation
    limits: Limits = field(default_factory=Limits)  # aspect ratio and volume

    def clip(self, solid: Solid) -> Solid:
        """The solid with what is required, and without what is not allowed."""
        joined = solid if self.required is None else solid | self.required
        return joined if self.allowed is None else joined & self.allowed


UNBOUND = Rules()


def rules_of(settings: EvolutionParameters, resolution: int | None = None) -> Rules:
    """The constraints as voxels, at a resolution; `UserError` if nothing could grow by them."""
    resolution = resolution or settings.shape.resolution
    mirror, shape = settings.symmetry.mirror, (resolution,) * 3

    def grid(region: Region) -> Solid | None:
        if region.kind == "none":
            return None
        mesh = mesh_of(region.mesh) if region.kind == "mesh" else None
        return region_voxels(region, resolution, mesh)

    inside, solid, hollow = map(grid, (settings.envelope, settings.keep_solid, settings.hole))
    void = np.zeros(shape, dtype=bool) if hollow is None else with_images(hollow, mirror)
    outside = np.zeros(shape, dtype=bool) if inside is None else with_images(~inside, mirror)
    kept = np.zeros(shape, dtype=bool) if solid is None else with_images(solid, mirror) & ~void
    allowed = (kept | ~outside) & ~void
    if solid is not None and not kept.any():
        raise UserError("keep_solid: all of its voxels are inside the hole")
    if not allowed.any():
        raise UserError("envelope and hole leave no voxel free for growth")
    return Rules(
        None if allowed.all() else allowed,
        None if solid is None else kept,
        settings.symmetry,
        settings.limits,
    )


def with_images(solid: Solid, mirror: tuple[str, ...]) -> Solid:
    """A solid joined with its mirror images."""
    for axis in mirror:
        solid = solid | np.flip(solid, AXES.index(axis))
    return solid


def solid(output: Singles, threshold: float, rules: Rules) -> Solid:
    """The one solid body that the output of a network describes within the rules.

    Voxels above the threshold are solid. Holes that no axis-parallel view shows are filled, thin
    parts are removed by an opening with the 6-neighborhood, and only the largest body is kept. The
    rules hold before and after. `RejectedError` if nothing is left, or it is against them.
    """
    filled = voxels.fill_orthographic(rules.clip(output > threshold))
    body = voxels.largest_body(rules.clip(ndimage.binary_opening(filled)))
    if rules.allowed is not None or rules.required is not None:
        body = _without_voids(body, rules)
    if not body.any():
        raise RejectedError("empty")
    if rules.required is not None and not body[rules.required].all():
        raise RejectedError("does not contain all of keep_solid")
    if not is_whole(body, rules.symmetry):
        raise RejectedError("one of several mirrored or rotated copies")
    _check_limits(body, rules.limits)
    return body


def _without_voids(body: Solid, rules: Rules) -> Solid:
    """A body with its voids filled; one that must stay empty would be filled by repair later."""
    full: Solid = ndimage.binary_fill_holes(body)
    if rules.allowed is not None and (full & ~rules.allowed).any():
        raise RejectedError("encloses space that must stay empty")
    return full


def _check_limits(body: Solid, limits: Limits) -> None:
    if limits == UNBOUND.limits:
        return
    sides = box_sides(body)
    volume = int(body.sum())
    values = {
        "aspect ratio": (sides.max() / sides.min(), limits.aspect_ratio),
        "fraction of its box": (volume / sides.prod(), limits.box_fraction),
        "fraction of the cube": (volume / body.size, limits.cube_fraction),
    }
    for name, (value, (low, high)) in values.items():
        if not low <= value <= high:
            raise RejectedError(f"{name} outside its limits ({value:.3g})")


def box_sides(body: Solid) -> Ints:
    """Sides of the axis-aligned box of a body, in voxels, (3,)."""
    return np.asarray(np.ptp(np.argwhere(body), axis=0) + 1)


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
