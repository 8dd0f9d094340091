"""Plates for 3D printers: every object checked, lying stably, packed onto beds."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import trimesh

from egad.evalset.filament import filament_mass
from egad.evalset.parameters import PrintCheck, PrintExport
from egad.evalset.print_poses import PrintPose, lie_down
from egad.evalset.printability import print_problems

Labelled = Iterable[tuple[str, trimesh.Trimesh]]
Watch = Callable[[Labelled], Labelled]

SMALL_CONTACT = 1e-4  # m2: a smaller first layer comes off the bed easily


@dataclass(frozen=True)
class PrintItem:
    """An object as it will be printed, lowest corner of its box at the origin; metres and kg.

    Filament is without supports; the place is x and y of that corner on the plate, both None if on
    none.
    """

    pose: PrintPose
    filament: float
    plate: int | None
    place: tuple[float, float] | None
    note: str


def plan_prints(
    meshes: Mapping[str, trimesh.Trimesh],
    settings: PrintExport,
    check: PrintCheck,
    watch: Watch = iter,
) -> dict[str, PrintItem]:
    """Turn closed meshes to their poses and pack all that can be printed onto few plates.

    `watch` passes the meshes through while they are turned, to show progress.
    """
    lying = {
        label: lie_down(mesh, settings.pose, int(np.argmax(settings.bed)))
        for label, mesh in watch(meshes.items())
    }
    problems = {label: print_problems(pose.mesh, check) for label, pose in lying.items()}
    sizes = {
        label: (pose.mesh.extents[0], pose.mesh.extents[1])
        for label, pose in lying.items()
        if not problems[label]
    }
    positions = pack(sizes, settings.bed, settings.gap, settings.keep_out)
    return {
        label: _item(pose, problems[label], positions.get(label), settings)
        for label, pose in lying.items()
    }


def _item(
    pose: PrintPose,
    problems: list[str],
    place: tuple[int, float, float] | None,
    settings: PrintExport,
) -> PrintItem:
    plate, where = (None, None) if place is None else (place[0], place[1:])
    filament = filament_mass(pose.mesh, settings)
    return PrintItem(pose, filament, plate, where, _note(pose, problems, plate, settings))


def _note(pose: PrintPose, problems: list[str], plate: int | None, settings: PrintExport) -> str:
    if problems:
        return f"not printable at this size: {', '.join(problems)}"
    if plate is None:
        size, bed = (
            " x ".join(f"{1000 * side:.0f}" for side in sides)
            for sides in (pose.mesh.extents[:2], settings.bed)
        )
        corner = " with its corner to keep out of" if all(settings.keep_out) else ""
        gap = f"{1000 * settings.gap:g} mm"
        return f"{size} mm plus a gap of {gap} do not fit the bed of {bed} mm{corner}"
    return "small contact with the bed: use a brim" if pose.contact < SMALL_CONTACT else ""


def pack(
    sizes: Mapping[str, tuple[float, float]],
    bed: tuple[float, float],
    gap: float,
    keep_out: tuple[float, float] = (0.0, 0.0),
) -> dict[str, tuple[int, float, float]]:
    """Place rectangles on shelves, deepest first, each on the first shelf with room for it.

    Plate number from 1, and x and y of the lowest corner, for each that fits a bed. The corner at
    the origin, `keep_out` wide and deep, stays free.
    """
    positions = {}
    shelves: list[_Shelf] = []
    for label, size in sorted(sizes.items(), key=lambda item: (-item[1][1], item[0])):
        fitting = (shelf for shelf in shelves if shelf.end + size[0] + gap <= bed[0])
        shelf = next(fitting, None) or _new_shelf(shelves, size, bed, gap, keep_out)
        if shelf is None:
            continue
        positions[label] = (shelf.plate, shelf.end, shelf.y)
        shelf.end += size[0] + gap
    return positions


@dataclass
class _Shelf:
    """A row of objects on a plate: where it begins, how deep it is, how far it is filled."""

    plate: int
    y: float
    depth: float
    end: float


def _new_shelf(
    shelves: list[_Shelf],
    size: tuple[float, float],
    bed: tuple[float, float],
    gap: float,
    keep_out: tuple[float, float],
) -> _Shelf | None:
    """Open a shelf on the first plate with room, beside or behind the corner; None without room."""
    width, depth = size
    last = {shelf.plate: shelf for shelf in shelves}  # of each plate, the one furthest back
    tops = {plate: shelf.y + shelf.depth + gap for plate, shelf in last.items()}
    for plate, top in (*tops.items(), (len(tops) + 1, gap)):
        for y in (top, max(top, keep_out[1] + gap)):
            x = gap + (keep_out[0] if y < keep_out[1] + gap else 0.0)
            if x + width + gap <= bed[0] and y + depth + gap <= bed[1]:
                shelves.append(_Shelf(plate, y, depth, x))
                return shelves[-1]
    return None
