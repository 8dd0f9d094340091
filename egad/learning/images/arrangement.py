"""Objects at rest on a table, and those of their grasps that a hand can reach from above."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.arrays import Flags, Floats, Ints
from egad.geometry import RayCaster
from egad.grasps import (
    APPROACH_WAY,
    ContactPairs,
    Sampling,
    first_approaches,
    robust_ferrari_canny,
    sample_contacts,
    valid_contacts,
)
from egad.grippers import HandBody
from egad.learning.images.parameters import RenderParameters
from egad.learning.images.reachability import is_reachable

UP = np.array([0.0, 0.0, 1.0])
ROUGH = 64  # candidates from which the size of an object is drawn
MAX_DIAGONAL = 0.2  # metres; diagonal of the bounding box of what lies beside others in an image


class PlacedObject(NamedTuple):
    """An object at rest on a table, at height 0 of its frame."""

    id: str
    factor: float  # size / that of the dataset's mesh
    mesh: trimesh.Trimesh  # its surface at this size, closed, metres
    com: Floats  # (3,) center of mass, metres
    matrix: Floats  # (4, 4) from the frame of the mesh to that of the table, z up
    pose: int = -1  # number of its stable pose; -1 if it was dropped or packed


class TableGrasps(NamedTuple):
    """Grasps whose approach is near to the vertical; metres, in the frame of the table."""

    objects: Ints  # (n,) numbers of the objects
    centers: Floats  # (n, 3) midpoints of the contacts
    axes: Floats  # (n, 3) unit vectors from the first contact to the second
    widths: Floats  # (n,) distances of the contacts
    free: Flags  # (n,) whether the hand touches nothing, at the grasp and on its straight approach
    qualities: Floats  # (n,) robust quality; 0 for those that are not free
    # (n,) whether the grasp held in simulation; None if it was not simulated
    success: NDArray[np.object_]


def is_good(free: Flags, qualities: Floats, success: Iterable[Any], quality: float) -> Flags:
    """Which of n grasps are free and held in simulation, or exceed a robust quality without one."""
    outcomes = list(success)
    known = np.array([each is not None for each in outcomes], dtype=bool)
    held = np.array([bool(each) for each in outcomes], dtype=bool)
    return free & np.where(known, held, qualities > quality)


def place(
    name: str, mesh: trimesh.Trimesh, com: Floats, factor: float, matrix: Floats, pose: int = -1
) -> PlacedObject:
    """An object resized by a factor; the matrix is for its frame at the new size."""
    sized = mesh if factor == 1 else mesh.copy().apply_scale(factor)
    return PlacedObject(name, factor, sized, com * factor, matrix, pose)


Simulate = Callable[[PlacedObject, ContactPairs, Floats], Sequence[bool | None]]
"""Whether grasps of an object, (n,), with approaches (n, 3), hold; all in the frame of its mesh."""


def table_grasps(
    objects: Sequence[PlacedObject],
    body: HandBody,
    settings: RenderParameters,
    rng: np.random.Generator,
    simulate: Simulate | None = None,
) -> TableGrasps:
    """Grasps of all objects on a table for a hand from above, rated where they are free."""
    casters = [RayCaster(_on_table([each])) for each in objects]
    scene = casters[0] if len(objects) == 1 else RayCaster(_on_table(objects))
    found = [
        _grasps_of(number, each, caster, scene, body, settings, rng, simulate)
        for number, (each, caster) in enumerate(zip(objects, casters, strict=True))
    ]
    return TableGrasps(*map(np.concatenate, zip(*found, strict=True)))


def sample_factor(
    caster: RayCaster,
    width: float,
    sampling: Sampling,
    rng: np.random.Generator,
    wanted: Callable[[Floats], Flags] | None = None,
) -> float:
    """Factor that gives a random grasp a width, metres; 0 without one, or if over 0.2 m (ours)."""
    length = float(np.linalg.norm(np.ptp(caster.triangles.reshape(-1, 3), axis=0)))
    pairs, _ = valid_contacts(caster, 1.01 * length, ROUGH, sampling, rng, wanted, 0.0)
    if len(pairs) == 0:
        return 0.0
    factor = float(width / pairs.widths[rng.integers(len(pairs))])
    return factor if factor * length <= MAX_DIAGONAL else 0.0


def near_level(up: Floats, tilt: float) -> Callable[[Floats], Flags]:
    """Tells which closing axes, (n, 3), allow an approach within `tilt` degrees of the vertical."""
    most = np.sin(np.radians(tilt))
    return lambda axes: np.asarray(np.abs(axes @ up) <= most)


def _on_table(objects: Sequence[PlacedObject]) -> trimesh.Trimesh:
    """Objects as one mesh in the frame of the table."""
    vertices = [each.mesh.vertices @ each.matrix[:3, :3].T + each.matrix[:3, 3] for each in objects]
    faces = [each.mesh.faces for each in objects]
    return trimesh.Trimesh(*trimesh.util.append_faces(vertices, faces), process=False)


def _grasps_of(
    number: int,
    placed: PlacedObject,
    caster: RayCaster,
    scene: RayCaster,
    body: HandBody,
    settings: RenderParameters,
    rng: np.random.Generator,
    simulate: Simulate | None,
) -> TableGrasps:
    """The grasps of one of the objects; the caster is for it alone, in the frame of the table."""
    opening, level = settings.gripper.opening, near_level(UP, settings.render.tilt)
    pairs, _ = sample_contacts(
        caster, opening, settings.render.grasps, settings.sampling, rng, level, clearance=0.0
    )
    free = is_reachable(scene, pairs.centers, pairs.axes, pairs.widths, body, way=APPROACH_WAY)
    rows = np.flatnonzero(free)
    qualities, success = np.zeros(len(free)), np.full(len(free), None)
    qualities[rows] = robust_ferrari_canny(
        caster,
        pairs.take(rows),
        placed.matrix[:3, :3] @ placed.com + placed.matrix[:3, 3],
        opening,
        quality=settings.quality,
        robust=settings.robust,
        rng=rng,
    )[0]
    if simulate:
        success[rows] = np.array([*simulate(placed, *_own(placed, pairs.take(rows)))], dtype=object)
    numbers = np.full(len(free), number)
    return TableGrasps(numbers, pairs.centers, pairs.axes, pairs.widths, free, qualities, success)


def _own(placed: PlacedObject, pairs: ContactPairs) -> tuple[ContactPairs, Floats]:
    """Grasps and their approaches, moved from the frame of the table to that of the mesh."""
    rotation, place = placed.matrix[:3, :3], placed.matrix[:3, 3]
    return (
        ContactPairs(
            (pairs.points - place) @ rotation, pairs.normals @ rotation, pairs.axes @ rotation
        ),
        first_approaches(pairs.axes) @ rotation,
    )
