"""Meshes of users: read, scaled to a gripper, decomposed, laid on a table."""

from pathlib import Path

import trimesh
from numpy.typing import ArrayLike

from egad._util.arguments import check_array, check_positive
from egad._util.arrays import Floats
from egad._util.files import as_path
from egad._util.parameters import MAX_SIDE_FRACTION, from_arguments
from egad._util.progress import phase_if_slow
from egad.evalset import Bundle, make_parts, measure_parts, warn_if_beyond
from egad.geometry import (
    DEVIATION,
    MAX_PARTS,
    MAX_VERTICES,
    SIDE_FRACTION,
    VOLUME_ERROR,
    check_units,
    mass_properties,
    scaling,
    wind_outwards,
)
from egad.geometry import stable_poses as resting
from egad.grippers import Gripper, as_gripper
from egad.io import read_mesh as read_any_mesh


def read_mesh(path: str | Path, units: str | None = None) -> trimesh.Trimesh:
    """Read a mesh file as one mesh in metres: obj, stl, ply, off, glb or 3mf.

    Polygons become triangles that lie within them. All objects, groups and nodes become one mesh,
    where the file puts them; vertices at the same place are merged. Colors, materials and normals
    are left out. glTF files have y up: they are turned to have z up. `docs/guides/own-meshes.md`
    lists what is read of each format.

    Args:
        path: The file.
        units: Unit of its coordinates: `m`, `cm`, `mm` or `inch`. It may be left out if the file
            states it (3mf, or a comment such as `unit: mm`), or the format does (glb: metres).

    Raises:
        RejectedError: The file is damaged, is not a mesh, has no faces, or has a feature that is
            not read, such as a free-form surface or a compressed mesh; the message names it. Or it
            states another unit than the one given, or neither gives one.
        UserError: The unit is unknown, or `path` is not a path.

    Warns:
        UnitsWarning: The size of the mesh suggests another unit.
    """
    file = as_path("path", path)
    mesh = read_any_mesh(file, units)
    check_units(mesh, f"the mesh {file.name}", units or "the unit of the file")
    return mesh


def rescale(
    mesh: trimesh.Trimesh,
    gripper: Gripper | str,
    rule: str = "paper",
    *,
    side_fraction: float = SIDE_FRACTION,
) -> tuple[trimesh.Trimesh, float]:
    """Scale an object about the origin of its coordinates to fit a gripper.

    Coordinates in single precision, such as those of the released objects, are rounded to single
    precision again.

    Args:
        mesh: Metres; not changed.
        gripper: The gripper, or its name.
        rule: `paper`: the smallest side of the minimum-volume box becomes at most the fraction of
            the opening, smaller objects stay as they are. `egad-script`: the longest side becomes
            the opening, then as `paper`. `exact`: the smallest side becomes the fraction. `none`:
            the object stays as it is.
        side_fraction: Fraction of the opening that the rule aims at.

    Returns:
        The scaled mesh, and the factor.

    Raises:
        RejectedError: The mesh is flat.
        UserError: There is no such gripper or rule, or the fraction is out of bounds.

    Warns:
        UnitsWarning: The size of the mesh suggests a unit other than the metre.
    """
    check_units(mesh)
    fraction = check_positive("side_fraction", side_fraction, MAX_SIDE_FRACTION)
    scaled, row = scaling.rescale(mesh, rule, as_gripper(gripper).opening, fraction)
    return scaled, row["factor"]


@phase_if_slow("decomposing a mesh into convex parts")
def convex_parts(
    mesh: trimesh.Trimesh,
    *,
    max_parts: int = MAX_PARTS,
    volume_error: float = VOLUME_ERROR,
    deviation: float = DEVIATION,
    max_vertices: int = MAX_VERTICES,
) -> list[trimesh.Trimesh]:
    """Convex meshes that together approximate a solid, for physics engines.

    Args:
        mesh: A closed surface, metres.
        max_parts: The largest number of parts. If it is not enough, volume error and deviation grow
            by the same factor until it is.
        volume_error: The parts may exceed the solid by this fraction of its volume.
        deviation: About 99 % of the surface that fingers can touch lies no deeper than this in a
            part, metres.
        max_vertices: The largest number of vertices of a part.

    Raises:
        RejectedError: The mesh does not bound a solid, or has more bodies than `max_parts`.
        UserError: A number is out of bounds.

    Warns:
        UnitsWarning: The size of the mesh suggests a unit other than the metre.
        PartsWarning: `max_parts` is not enough; the text has the bounds that the parts keep.
    """
    check_units(mesh)
    wanted = from_arguments(
        Bundle,
        max_parts=max_parts,
        volume_error=volume_error,
        deviation=deviation,
        max_vertices=max_vertices,
    )
    solid = wind_outwards(mesh)
    found = make_parts(solid, wanted)
    if found.deviation > wanted.deviation:
        errors = measure_parts(solid, found.parts, wanted)
        warn_if_beyond("the mesh", False, errors.volume_error, found.deviation)
    return found.parts


def stable_poses(
    mesh: trimesh.Trimesh, center_of_mass: ArrayLike | None = None
) -> list[resting.StablePose]:
    """The poses in which a solid can rest on a table, the most probable first.

    Args:
        mesh: A closed surface, in any unit; any surface if the center of mass is given, because
            then only its convex hull matters.
        center_of_mass: (3,) in the unit of the mesh; by default that of a solid of uniform density.

    Returns:
        At least one pose, with probabilities that add up to 1. `pose.matrix` is the (4, 4)
        transform from the frame of the mesh to that of the table: z points up, the table is at
        z = 0, and the center of mass is above the origin.

    Raises:
        RejectedError: The mesh is flat, or the center of mass is not inside its hull. Or the
            center of mass is not given, and the mesh is open or inside out.
        UserError: It is not a mesh, or the center of mass is not 3 finite numbers.

    Source: after Goldberg et al., Part pose statistics, 1999.
    """
    return resting.stable_poses(mesh, center_or_given(mesh, center_of_mass))


def center_or_given(mesh: trimesh.Trimesh, given: ArrayLike | None) -> Floats:
    """The center of mass that is given, or that of the solid."""
    if given is None:
        return mass_properties(mesh, 1.0).com
    return check_array("center_of_mass", given, (3,), "3 finite numbers")
