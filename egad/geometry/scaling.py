"""Scaling objects to the opening of a gripper."""

from typing import Any

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from scipy.optimize import minimize
from scipy.spatial import QhullError
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.errors import RejectedError, check_name
from egad.geometry.checks import check_mesh
from egad.geometry.rounding import is_single, to_single

TURNS = 800  # orientations tried, about 8 degrees apart, given the 24 symmetries of the box
STARTS = 3  # how many of the best ones are turned further
FEW = 0  # digits of the face angles that trimesh compares: few faces of a smooth hull are enough
TILT = 0.05  # radians: first step of turning them further
FLAT = 1e-9  # smallest side over longest: less is rounding
ENLARGED = 1 + 1e-9  # a larger factor is more than rounding
AT_ONCE = 50  # orientations multiplied with the points at once: the products fit into the cache


def box_sides(mesh: trimesh.Trimesh) -> Floats:
    """Sides of the minimum-volume oriented box, ascending, (3,) (ours); `RejectedError` if flat.

    It need not touch a face of the hull, as trimesh's does: several boxes are turned to a minimum.
    """
    check_mesh(mesh)
    try:
        hull = trimesh.convex.convex_hull(mesh, repair=False)  # only its vertices are used
    except QhullError as error:
        raise RejectedError("flat") from error
    points = np.ascontiguousarray(np.asarray(hull.vertices).T)
    turns = _even_turns(TURNS)
    batches = (turns[start : start + AT_ONCE] for start in range(0, TURNS, AT_ONCE))
    extents = np.concatenate([_extents(batch.reshape(-1, 3) @ points) for batch in batches])
    extents = extents.reshape(TURNS, 3)
    best = np.argsort(extents.prod(axis=1), kind="stable")[:STARTS]
    to_box, _ = trimesh.bounds.oriented_bounds(hull, angle_digits=FEW)
    starts = [np.asarray(to_box)[:3, :3], *turns[best]]
    boxes = [_turned_to_minimum(start @ points) for start in starts]
    sides = np.sort(min(boxes, key=np.prod))
    if not sides[0] > FLAT * sides[-1]:
        raise RejectedError("flat")
    return sides


def _turned_to_minimum(points: Floats) -> Floats:
    """Sides of the smallest axis-aligned box that small turns of points (3, n) lead to, (3,)."""

    def sides(turn: Floats) -> Floats:
        return _extents(Rotation.from_rotvec(turn).as_matrix() @ points)

    unit = float(sides(np.zeros(3)).prod())
    if unit == 0:
        raise RejectedError("flat")

    def volume(turn: Floats) -> float:
        return float(sides(turn).prod()) / unit

    simplex = np.vstack([np.zeros(3), TILT * np.eye(3)])
    options: Any = {"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-4, "maxiter": 300}
    return sides(minimize(volume, np.zeros(3), method="Nelder-Mead", options=options).x)


def _extents(rows: Floats) -> Floats:
    """Range of each row: fast, because rows are contiguous in memory."""
    return np.asarray(rows.max(axis=1) - rows.min(axis=1))


def _even_turns(count: int) -> Floats:
    """Rotations spread evenly, (count, 3, 3). Source: Alexa, Super-Fibonacci spirals, CVPR 2022."""
    height = (np.arange(count) + 0.5) / count
    first, second = (2 * np.pi * count * height / step for step in (2**0.5, 1.533751168755204))
    quaternions = [
        np.sqrt(height) * np.sin(first),
        np.sqrt(height) * np.cos(first),
        np.sqrt(1 - height) * np.sin(second),
        np.sqrt(1 - height) * np.cos(second),
    ]
    return np.asarray(Rotation.from_quat(np.column_stack(quaternions)).as_matrix())


def scale_factor(rule: str, sides: Floats, opening: float, side_fraction: float) -> float:
    """The factor by which a rule scales an object with box sides (3,) to an opening, metres.

    `paper`: the smallest side becomes at most the fraction of the opening (EGAD, section IV).
    `egad-script`: the longest side becomes the opening, then as `paper` (EGAD's released script).
    `exact`: the smallest side becomes the fraction (EGAD's graspability). `none`: 1.
    """
    fitting = side_fraction * opening / float(sides[0])
    factors = {
        "paper": min(1.0, fitting),
        "egad-script": min(opening / float(sides[-1]), fitting),
        "exact": fitting,
        "none": 1.0,
    }
    return factors[check_name("rule", rule, factors)]


def size_text(sides: ArrayLike, factor: float) -> str:
    """A scaled size in words, such as `40 x 52.3 x 60 mm, 0.8 times its size`; sides in metres."""
    millimetres = " x ".join(map(_digits, 1000 * np.asarray(sides)))
    return f"{millimetres} mm, {_digits(factor)} times its size"


def _digits(value: float) -> str:
    """A number with three significant digits, without an exponent."""
    return np.format_float_positional(value, precision=3, fractional=False, trim="-")


def scale_suffix(rule: str, opening: float) -> str:
    """What tells files of scaled meshes apart: rule and opening, such as `_paper_75mm`."""
    return f"_{rule}_{1000 * opening:g}mm"


def rescale(
    mesh: trimesh.Trimesh, rule: str, opening: float, side_fraction: float
) -> tuple[trimesh.Trimesh, dict[str, Any]]:
    """An object scaled about the origin, and its row of `SCALES`; `RejectedError` if it is flat."""
    before = box_sides(mesh)
    factor = scale_factor(rule, before, opening, side_fraction)
    vertices = np.asarray(mesh.vertices) * factor
    if is_single(mesh.vertices):
        vertices = to_single(vertices)
    scaled = trimesh.Trimesh(vertices, mesh.faces, process=False)
    row = {"rule": rule, "opening": opening, "factor": factor}
    row |= {f"before_{n}": float(side) for n, side in enumerate(before, 1)}
    row |= {f"after_{n}": float(side * factor) for n, side in enumerate(before, 1)}
    return scaled, row
