"""Ten household parts made of solids, in their own sizes, that no search of the study sees."""

from collections.abc import Callable

import numpy as np
import trimesh
from manifold3d import CrossSection, JoinType, Manifold

SEGMENTS = 64  # of a full turn


def household_parts() -> dict[str, trimesh.Trimesh]:
    """Closed meshes by name, metres."""
    return {name: _mesh(make()) for name, make in PARTS.items()}


def _mesh(solid: Manifold) -> trimesh.Trimesh:
    """A solid in millimetres as a mesh in metres."""
    made = solid.to_mesh64()
    return trimesh.Trimesh(np.asarray(made.vert_properties)[:, :3] / 1000, made.tri_verts)


def _pin(radius: float, height: float, top: float | None = None) -> Manifold:
    """A cylinder or a cone on the origin, along z."""
    return Manifold.cylinder(height, radius, radius if top is None else top, SEGMENTS)


def _box(*sides: float) -> Manifold:
    """A box, its middle at the origin."""
    return Manifold.cube(sides, True)


def _along_x(solid: Manifold) -> Manifold:
    """What lay along z, along x."""
    return solid.rotate((0, 90, 0))


def _mug() -> Manifold:
    ring = CrossSection.circle(4, 24).translate((20, 0)).revolve(SEGMENTS).rotate((90, 0, 0))
    body, hollow = _pin(38, 85), _pin(34.5, 85).translate((0, 0, 4))
    return body + ring.translate((40, 0, 42)) - hollow


def _screwdriver() -> Manifold:
    return _along_x(_pin(12, 80) + _pin(3, 90).translate((0, 0, 80)) + _pin(8, 6, 12))


def _saucer() -> Manifold:
    return _pin(30, 15, 60) - _pin(28, 15, 58).translate((0, 0, 3))


def _clothes_peg() -> Manifold:
    arm = _box(75, 10, 5)
    lower, upper = arm.rotate((0, 4, 0)), arm.rotate((0, -4, 0)).translate((0, 0, 7))
    spring = _pin(4, 12).rotate((90, 0, 0)).translate((0, 6, 3.5))
    return lower + upper + spring


def _bottle() -> Manifold:
    shoulder = _pin(27, 20, 11).translate((0, 0, 80))
    return _pin(27, 80) + shoulder + _pin(11, 22).translate((0, 0, 100))


def _spoon() -> Manifold:
    bowl = Manifold.sphere(1, SEGMENTS).scale((26, 18, 8)).trim_by_plane((0, 0, -1), 0)
    hollow = Manifold.sphere(1, SEGMENTS).scale((23.5, 15.5, 6))
    return (bowl - hollow) + _box(100, 9, 3).translate((73, 0, -1.5))


def _bracket() -> Manifold:
    angle = _box(45, 25, 4).translate((22.5, 0, 2)) + _box(4, 25, 45).translate((2, 0, 22.5))
    hole = _pin(3, 10)
    return angle - hole.translate((30, 0, -3)) - _along_x(hole).translate((-3, 0, 30))


def _hook() -> Manifold:
    turn = CrossSection.square((10, 12), True).translate((20, 0)).revolve(SEGMENTS, 200)
    return turn + _box(10, 60, 12).translate((20, -28, 0))


def _knob() -> Manifold:
    lobes = [CrossSection.circle(9, 32).translate((15, 0)).rotate(72 * n) for n in range(5)]
    outline = CrossSection.circle(17, SEGMENTS)
    for lobe in lobes:
        outline += lobe
    return outline.extrude(16) + _pin(8, 20).translate((0, 0, 14))


def _soap_box() -> Manifold:
    outline = CrossSection.square((78, 46), True).offset(6, JoinType.Round, 2, 32)
    return outline.extrude(28) - outline.offset(-2.5, JoinType.Round, 2, 32).extrude(28).translate(
        (0, 0, 2.5)
    )


PARTS: dict[str, Callable[[], Manifold]] = {
    "mug": _mug,
    "screwdriver": _screwdriver,
    "saucer": _saucer,
    "clothes peg": _clothes_peg,
    "bottle": _bottle,
    "spoon": _spoon,
    "bracket": _bracket,
    "hook": _hook,
    "knob": _knob,
    "soap box": _soap_box,
}
