"""The filament of a print, from sections through its layers as slicers fill them (ours)."""

from collections.abc import Callable
from functools import cache
from typing import Any

import manifold3d
import numpy as np
import trimesh

from egad.evalset.parameters import PrintExport
from egad.evalset.print_poses import LAYER
from egad.geometry import to_solid

Section = Any  # manifold3d.CrossSection, which has no type information
Sections = Callable[[int], Section]

STEP = 5  # layers between sections, except near the bottom and the top
STRIP = 0.002  # metres; solid strips narrower than twice this become wider by it on each side
ISLAND = 7e-5  # m2: slicers fill smaller islands of sparse infill solidly
MITER = manifold3d.JoinType.Miter
ROUNDING = 1e-6  # metres


def print_settings(settings: PrintExport) -> str:
    """The print settings behind the estimated filament, in the terms of slicers."""
    return (
        f"layer height {1000 * LAYER:g} mm, line width {1000 * settings.line_width:g} mm, "
        f"perimeters {settings.perimeters}, solid layers {settings.solid_layers} at the bottom and "
        f"the top, infill {100 * settings.infill:g} %"
    )


def filament_mass(mesh: trimesh.Trimesh, settings: PrintExport) -> float:
    """Mass of a print without supports, kg.

    Every fifth layer represents those around it; the lowest and highest ones, which are solid, are
    all computed.
    """
    bottom, top = mesh.bounds[:, 2]
    solid = to_solid(mesh.vertices, mesh.faces)

    @cache
    def section(layer: int) -> Section:
        """Through the middle of a layer; below and above the object it is empty."""
        return solid.slice(bottom + (layer + 0.5) * LAYER)

    count = max(1, round((top - bottom) / LAYER))
    solid_layers = min(settings.solid_layers, count)
    between = range(solid_layers, count - solid_layers, STEP)
    ends = {*range(solid_layers), *range(count - solid_layers, count), count}
    starts = np.array(sorted(ends.union(between)))
    middles = (starts[:-1] + starts[1:]) // 2
    areas = [_filled_area(section, int(layer), settings) for layer in middles]
    return float(settings.filament_density * LAYER * np.dot(np.diff(starts), areas))


def _filled_area(section: Sections, layer: int, settings: PrintExport) -> float:
    """Area of a layer that filament fills, m2: all but the gaps of the sparse infill.

    Infill is sparse within the perimeters where as many neighboring layers cover it as are solid at
    the bottom and the top, but not beside narrow strips without cover. Its lines are anchored along
    the lines around it, which takes as much filament as if the infill reached one line further.
    """
    line = line_spacing(settings.line_width)
    whole = section(layer)
    inside = whole.offset(-settings.perimeters * line, MITER)
    covered = inside
    for distance in range(1, settings.solid_layers + 1):
        covered ^= section(layer - distance) ^ section(layer + distance)
    sparse = inside - _widened(inside - covered)
    gaps = [
        max(0.0, island.area() - settings.infill * island.offset(line, MITER).area())
        for island in sparse.decompose()
        if island.area() > ISLAND
    ]
    return float(whole.area() - sum(gaps))


def line_spacing(width: float) -> float:
    """Distance between lines with round sides, two half discs, so that no gaps remain, metres."""
    return width - (1 - np.pi / 4) * LAYER


def _widened(solid: Section) -> Section:
    """Areas of solid infill with narrow strips made wider, as slicers do."""
    wide = solid.offset(-STRIP, MITER).offset(STRIP + ROUNDING, MITER)
    return solid + (solid - wide).offset(STRIP, MITER)
