"""Whether fingertips can be printed, and whether the hand with them works: sentences if not."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.bench.tips.base import Base
from egad.bench.tips.files import PLA, write_hand
from egad.bench.tips.parameters import FingertipDesign, TipLimits
from egad.bench.tips.solids import Tip, make_tips, union_of_hulls
from egad.errors import UserError
from egad.evalset import PrintCheck, first_layer_area, overhang_area, print_problems
from egad.geometry import to_mesh
from egad.grippers import FINGERS, Gripper, model_of

TOUCH = 1e-10  # m3 that bodies may overlap by: 0.1 mm on a face of 1 mm2
FOOTHOLD = 2e-5  # m2 of the first layer, below which a print comes off the bed
MODULUS = 2.3e9  # pascals, Young's modulus of printed PLA
OVERHANG = 4e-5  # m2 that are printed without support
CLOSED = 1.5e-3  # metres between closed tips at most
STEPS = 9  # openings at which collisions are looked for
NAMES = ("the first tip", "the second tip")
SIDES = Rotation.create_group("O").as_matrix()  # that may lie on the bed


def hand_with_tips(base: Base, design: FingertipDesign, tips: Sequence[Tip], out: Path) -> Gripper:
    """A hand with tips, as read from its files; a jaw that turns keeps the torque of its joint."""
    path = write_hand(base, tips, out)
    gripper = base.gripper
    kept = gripper.model_dump(include={"pads", "friction", "sampler", "joint", "finger_links"})
    if not base.turns:
        return Gripper.from_file(path, force=gripper.force, **kept)
    torque = gripper.torque or gripper.force * (base.model.lever or 1.0)
    depth = design.overlap + design.grip * tips[0].free
    tcp = tips[0].pose[:3] @ [design.thickness, 0.0, depth, 1.0]
    return Gripper.from_file(path, torque=torque, tcp=tuple(tcp.tolist()), **kept)


def tip_problems(
    base: Base, design: FingertipDesign, limits: TipLimits, folder: Path
) -> tuple[Gripper | None, list[str]]:
    """The hand with tips as read from its files, if it can be, and sentences on what is wrong."""
    try:
        tips = make_tips(base, design)
        hand = hand_with_tips(base, design, tips, folder)
    except UserError as error:
        return None, [str(error).removeprefix(f"{folder / 'hand.urdf'}: ")]
    return hand, [
        *_print_problems(tips, limits),
        *_hand_problems(base, tips, design, hand, limits),
        *_collisions(design, hand, limits.smallest),
    ]


def _print_problems(tips: Sequence[Tip], limits: TipLimits) -> Iterator[str]:
    """Walls of the plates, and overhangs of what is added to the jaws; screw holes are bridged."""
    for name, tip in zip(NAMES, tips, strict=True):
        plate = to_mesh(union_of_hulls(tip.pieces[:-1]))
        for problem in print_problems(plate, PrintCheck(wall=limits.wall)):
            yield f"{name} cannot be printed: its plate has {problem}"
        overhang = overhang_area(tip.added, print_rotation(tip.added, tip.pose))
        if overhang > OVERHANG:
            yield f"{name} needs support in every pose: {1e6 * overhang:.0f} mm2 hang over"


def print_rotation(mesh: trimesh.Trimesh, pose: Floats) -> Floats:
    """The rotation (3, 3) that lays a tip on the bed: the lowest that needs no support, if any."""

    def worth(turn: Floats) -> tuple[float, float]:
        height = float(np.ptp(mesh.vertices @ turn[2]))
        return max(overhang_area(mesh, turn), OVERHANG), height

    own = pose[:3, :3].T
    turns = [side @ own for side in SIDES]
    firm = [turn for turn in turns if first_layer_area(mesh, turn) >= FOOTHOLD]
    return min(firm or turns, key=worth)


def _hand_problems(
    base: Base, tips: Sequence[Tip], design: FingertipDesign, hand: Gripper, limits: TipLimits
) -> Iterator[str]:
    """What the hand cannot do, mass, and how far a plate bends."""
    closed, mass = float(model_of(hand).openings[0]), PLA * sum(tip.added.volume for tip in tips)
    if closed > CLOSED:
        yield f"the hand does not close fully: its tips stay {1000 * closed:.1f} mm apart"
    if hand.opening < limits.smallest:
        yield (
            f"the hand opens {1000 * hand.opening:.1f} mm, less than the smallest object is thick: "
            f"{1000 * limits.smallest:.1f} mm"
        )
    if hand.force < limits.force:
        yield (
            f"the hand presses with {hand.force:.1f} N at its pads, {base.gripper.force:.1f} N "
            f"without tips; at least {limits.force:.1f} N are needed"
        )
    if mass > limits.mass:
        yield f"the tips weigh {1000 * mass:.0f} g, allowed: {1000 * limits.mass:.0f}"
    if (bend := bending(design, tips[0].free, hand.force)) > limits.bend:
        yield (
            f"the plates bend {1000 * bend:.1f} mm at their tips under {hand.force:.1f} N, "
            f"allowed: {1000 * limits.bend:.1f}: make them thicker or shorter"
        )


def bending(design: FingertipDesign, free: float, force: float) -> float:
    """How far a force, N, bends the end of a plate of free length, m; a groove counts in full."""
    along = design.groove_angle and design.groove_depth and design.groove_direction == "along"
    thick = design.thickness - (design.groove_depth if along else 0.0)
    return 4 * force * free**3 / (MODULUS * design.width * thick**3)


def _collisions(design: FingertipDesign, hand: Gripper, smallest: float) -> Iterator[str]:
    """Where a tip meets the other jaw before the smallest object; by the hinge, jaws may touch."""
    model = model_of(hand)
    for opening in np.linspace(max(hand.opening, smallest), smallest, STEPS):
        first, second = (union_of_hulls(model.corners(float(opening), side)) for side in FINGERS)
        both = (first ^ second).trim_by_plane((0.0, 0.0, 1.0), -design.length - design.overlap)
        if both.volume() > TOUCH:
            yield f"the jaws with the tips meet where the hand is {1000 * opening:.1f} mm open"
            return
