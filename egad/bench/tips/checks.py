"""Whether fingertips can be printed, and whether the hand with them works: sentences if not."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial import ConvexHull

from egad._util.arrays import Floats, Ints
from egad.bench.tips.base import Base, pose_of
from egad.bench.tips.files import write_hand
from egad.bench.tips.parameters import FingertipDesign, TipLimits
from egad.bench.tips.solids import Tip, make_tips
from egad.errors import UserError
from egad.evalset import PrintCheck, first_layer_area, overhang_area, print_problems
from egad.geometry import is_solid, to_solid
from egad.grippers import PALM_BODY, SECOND_FINGER, Gripper, model_of

TOUCH = 1e-10  # m3 that bodies may overlap by: 0.1 mm on a face of 1 mm2
FOOTHOLD = 2e-5  # m2 of the first layer, below which a print comes off the bed
GLUE = 3e-5  # m2 of the jaw that a foot must lie against
CLOSING = 2e-3  # metres above the closed hand, from where on tips may touch
INSIDE = 1e-6  # metres within a foot
STEPS = 9  # openings at which collisions are looked for
NAMES = ("the first tip", "the second tip")
SIDES = np.array([np.eye(3)[list(order)] * sign for order in ((1, 2, 0), (2, 0, 1), (0, 1, 2))
                  for sign in (1, -1)])  # fmt: skip


def hand_with_tips(base: Base, tips: Sequence[Tip], folder: Path, density: float) -> Gripper:
    """Write a hand with fingertips, see `write_hand`, and read it again.

    A jaw that turns keeps the torque of its joint, so its force follows from the new lever; jaws
    that slide keep their force.

    Raises:
        UserError: No jaws are found in what was written; the message says what is wrong with them.
    """
    path = write_hand(base, tips, folder, density)
    gripper = base.gripper
    kept = {"pads": gripper.pads, "friction": gripper.friction}
    if not base.turns:
        return Gripper.from_file(path, force=gripper.force, **kept)
    torque = gripper.torque or gripper.force * (base.model.lever or 1.0)
    return Gripper.from_file(path, torque=torque, **kept)


def tip_problems(
    base: Base, design: FingertipDesign, limits: TipLimits, folder: Path
) -> tuple[Gripper | None, list[str]]:
    """The hand with fingertips of a design, and what is wrong with it, in sentences.

    Args:
        base: The hand.
        design: Dimensions of the tips.
        limits: What they must fulfil.
        folder: Where the files of the hand are written.

    Returns:
        The hand as read from its file, None if it cannot be; and the problems, none if it can be
        printed, closes fully, spans the smallest object, and holds it firmly enough.
    """
    try:
        tips = make_tips(base, design)
        hand = hand_with_tips(base, tips, folder, limits.density)
    except UserError as error:
        return None, [str(error)]
    return hand, [
        *_print_problems(tips, limits),
        *_hand_problems(base, hand, limits),
        *_strength_problems(tips, design, hand, limits),
        *_collisions(base, tips, hand),
    ]


def _print_problems(tips: Sequence[Tip], limits: TipLimits) -> Iterator[str]:
    """Walls, loose parts and overhangs."""
    for name, tip in zip(NAMES, tips, strict=True):
        for problem in print_problems(tip.plate, PrintCheck(wall=limits.wall)):
            yield f"{name} cannot be printed: its plate has {problem}"
        if tip.mesh.body_count != 1 or not tip.mesh.is_watertight:
            yield f"{name} cannot be printed: its foot is not one solid"
        overhang = overhang_area(tip.mesh, print_rotation(tip))
        if overhang > limits.overhang:
            yield (
                f"{name} needs support in every pose: {1e6 * overhang:.0f} mm2 hang over, allowed: "
                f"{1e6 * limits.overhang:.0f}"
            )


def print_rotation(tip: Tip) -> Floats:
    """The rotation (3, 3) that lays a tip on the side of its plate with the least overhang."""
    own = tip.pose[:3, :3].T
    turns = [side @ own for side in SIDES]
    firm = [turn for turn in turns if first_layer_area(tip.mesh, turn) >= FOOTHOLD]
    return min(firm or turns, key=lambda turn: overhang_area(tip.mesh, turn))


def _hand_problems(base: Base, hand: Gripper, limits: TipLimits) -> Iterator[str]:
    """What the hand cannot do."""
    closed = float(model_of(hand).openings[0])
    if closed > limits.closed:
        yield (
            f"the hand does not close fully: at the limit of its joint the tips are "
            f"{1000 * closed:.1f} mm apart, allowed: {1000 * limits.closed:.1f}"
        )
    if hand.opening < limits.smallest:
        yield (
            f"the hand opens {1000 * hand.opening:.1f} mm, less than the smallest object is thick: "
            f"{1000 * limits.smallest:.1f} mm"
        )
    if hand.force < limits.force:
        why = f", with {base.gripper.force:.1f} N without tips" if base.turns else ""
        yield (
            f"the hand presses with {hand.force:.1f} N at its pads{why}; at least "
            f"{limits.force:.1f} N are needed"
        )


def _strength_problems(
    tips: Sequence[Tip], design: FingertipDesign, hand: Gripper, limits: TipLimits
) -> Iterator[str]:
    """Mass, how far a plate bends, and how much of a foot lies against its jaw."""
    mass = limits.density * sum(float(tip.mesh.volume) for tip in tips)
    if mass > limits.mass:
        yield f"the tips weigh {1000 * mass:.0f} g, allowed: {1000 * limits.mass:.0f}"
    bend = bending(design, hand.force, limits.modulus)
    if bend > limits.bend:
        yield (
            f"the plates bend {1000 * bend:.1f} mm at their tips under {hand.force:.1f} N, "
            f"allowed: {1000 * limits.bend:.1f}: make them thicker or shorter"
        )
    for name, tip in zip(NAMES, tips, strict=True):
        if (area := glued_area(tip)) < GLUE:
            yield f"{name} has only {1e6 * area:.0f} mm2 to glue on, at least {1e6 * GLUE:.0f}"


def bending(design: FingertipDesign, force: float, modulus: float) -> float:
    """How far a force at the end of a plate, N, bends it: a cantilever beyond the jaw, metres.

    A groove along the plate counts as if the whole plate were as thin as at its bottom.
    """
    along = design.groove_angle and design.groove_depth and design.groove_direction == "along"
    thick = design.thickness - (design.groove_depth if along else 0.0)
    return 4 * force * design.length**3 / (modulus * design.width * thick**3)


def glued_area(tip: Tip) -> float:
    """Surface of a tip that the jaw cut out of its foot, m2: what lies within the uncut foot."""
    planes = ConvexHull(tip.pieces[-1]).equations
    middles = tip.mesh.triangles_center
    within = (middles @ planes[:, :3].T + planes[:, 3] < -INSIDE).all(axis=1)
    return float(tip.mesh.area_faces[within].sum())


def _hull(points: Floats) -> tuple[Floats, Ints]:
    hull = trimesh.convex.convex_hull(points)
    return hull.vertices, np.asarray(hull.faces)


def _collisions(base: Base, tips: Sequence[Tip], hand: Gripper) -> Iterator[str]:
    """Where a tip meets the palm or the other jaw before the hand is closed."""
    model = model_of(hand)
    closed = float(model.openings[0]) + CLOSING
    openings = np.linspace(max(float(model.openings[-1]), closed), closed, STEPS)
    for name, tip, other in zip(NAMES, tips, tips[::-1], strict=True):
        for opening in openings:
            hit = _hit(base, tip, other, hand, float(opening))
            if hit:
                yield f"{name} meets {hit} where the hand is {1000 * opening:.1f} mm open"
                break


def _hit(base: Base, tip: Tip, other: Tip, hand: Gripper, opening: float) -> str:
    """What a tip overlaps at an opening, among the other tip and links of another body."""
    model = model_of(hand)
    names = [link.name for link in model.links]

    def placed(link: int, points: Floats) -> Floats:
        name = base.model.links[link].name
        pose = pose_of(model, names.index(name), opening)
        return np.asarray(trimesh.transform_points(points, pose))

    own = to_solid(placed(tip.link, tip.mesh.vertices), tip.mesh.faces)
    side = base.model.links[tip.link].body
    obstacles = [("the other tip", placed(other.link, piece)) for piece in other.pieces[:-1]]
    near = {side} if side == SECOND_FINGER or base.model.lever is None else {side, PALM_BODY}
    for number, link in enumerate(base.model.links):
        if link.body not in near:
            obstacles += [(f"the link {link.name}", placed(number, part)) for part in link.shapes]
    for name, points in obstacles:
        shared = own ^ to_solid(*_hull(points))
        if is_solid(shared) and shared.volume() > TOUCH:
            return name
    return ""
