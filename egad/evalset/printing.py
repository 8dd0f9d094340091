"""Plates for 3D printers: every object lying stably, packed onto beds."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray


@dataclass(frozen=True)
class PrintItem:
    """An object lying as it will be printed, in metres, lowest corner of its box at the origin.

    `plate` and `place` (x and y of the lowest corner on it) are None if it does not fit the bed.
    """

    mesh: trimesh.Trimesh
    plate: int | None
    place: tuple[float, float] | None
    note: str


def plan_prints(
    meshes: Mapping[str, trimesh.Trimesh], bed: tuple[float, float], gap: float
) -> dict[str, PrintItem]:
    """Turn every object to its most stable pose and pack all onto as few plates as come easily.

    Args:
        meshes: Watertight meshes in metres, by label.
        bed: Sides of the bed, metres.
        gap: Free space between objects, and to the edge of the bed, metres.

    Returns:
        One item for each label, in the order given.
    """
    lying = {label: lie_down(mesh) for label, mesh in meshes.items()}
    sizes = {label: (mesh.extents[0], mesh.extents[1]) for label, mesh in lying.items()}
    places = pack(sizes, bed, gap)
    return {label: _item(mesh, places.get(label), bed) for label, mesh in lying.items()}


def _item(
    mesh: trimesh.Trimesh, place: tuple[int, float, float] | None, bed: tuple[float, float]
) -> PrintItem:
    if place is None:
        size = " x ".join(f"{1000 * side:.0f}" for side in mesh.extents[:2])
        note = f"{size} mm is larger than the bed of {1000 * bed[0]:.0f} x {1000 * bed[1]:.0f} mm"
        return PrintItem(mesh, None, None, note)
    plate, x, y = place
    return PrintItem(mesh, plate, (x, y), "")


def lie_down(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy turned to its most probable resting pose, box corner at the origin.

    Turned about the vertical until its footprint's rectangle is smallest, longer side along x.
    """
    poses, probabilities = trimesh.poses.compute_stable_poses(mesh, sigma=0, n_samples=1)
    turned = mesh.copy()
    if len(poses):
        turned.apply_transform(poses[int(np.argmax(probabilities))])
    turned.apply_transform(_align_with_bed(turned))
    turned.apply_translation(-turned.bounds[0])
    return trimesh.Trimesh(turned.vertices, turned.faces, process=False)


def _align_with_bed(mesh: trimesh.Trimesh) -> NDArray[np.float64]:
    """The turn about the vertical that makes the rectangle around a mesh smallest."""
    flat, sides = trimesh.bounds.oriented_bounds_2D(mesh.vertices[:, :2])
    turn = np.eye(4)
    turn[:2, :2] = flat[:2, :2]
    if sides[1] > sides[0]:
        turn[:2] = [-turn[1], turn[0]]
    return turn


def pack(
    sizes: Mapping[str, tuple[float, float]], bed: tuple[float, float], gap: float
) -> dict[str, tuple[int, float, float]]:
    """Place rectangles on shelves, deepest first, plate after plate.

    Args:
        sizes: Width and depth by label.
        bed: Width and depth of a plate.
        gap: Free space around each.

    Returns:
        Plate number from 1, and x and y of the lowest corner, for each that fits a bed.
    """
    places = {}
    plate, x, y, shelf = 1, gap, gap, 0.0
    for label, (width, depth) in sorted(sizes.items(), key=lambda item: (-item[1][1], item[0])):
        if width + 2 * gap > bed[0] or depth + 2 * gap > bed[1]:
            continue
        if x + width + gap > bed[0]:
            x, y, shelf = gap, y + shelf + gap, 0.0
        if y + depth + gap > bed[1]:
            plate, x, y, shelf = plate + 1, gap, gap, 0.0
        places[label] = (plate, x, y)
        x, shelf = x + width + gap, max(shelf, depth)
    return places
