"""The way of a described hand from open to closed, as positions of all its joints."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from egad._util.arrays import Floats
from egad.errors import UserError
from egad.grippers.fingers import Sides
from egad.grippers.mechanism import Mechanism
from egad.grippers.pads import Pads, find_pads
from egad.grippers.tree import body_name

LEVELS = 65  # openings that are tabulated
MIN_OPENING, MAX_OPENING = 0.5e-3, 1.0  # metres


class Stroke(NamedTuple):
    """The way from closed to open."""

    positions: Floats  # (k, q) positions of all joints
    middles: Floats  # (k, 2, 3) middles of both pads, in the frame of the palm, metres
    pads: Pads  # the faces that meet


def find_stroke(mechanism: Mechanism, sides: Sides, links: Sequence[str] | None = None) -> Stroke:
    """The part of the way on which the pads come together until they meet, or `UserError`."""
    way = _follow(mechanism, sides, np.linspace(0, 1, LEVELS))
    pads = find_pads(mechanism, way[-1], sides, links)

    def gap(part: float) -> float:
        """Distance between the pads at a fraction of the way."""
        (middles,) = _middles(mechanism, _follow(mechanism, sides, np.array([part])), pads)
        return float((middles[1] - middles[0]) @ sides.axis)

    middles = _middles(mechanism, way, pads)
    names = " and ".join(body_name(mechanism.model, link) for link in pads.links)
    start, end = _useful((middles[:, 1] - middles[:, 0]) @ sides.axis, names)
    closed = end if gap(end) >= 0 else brentq(gap, start, end, xtol=1e-9)
    way = _follow(mechanism, sides, np.linspace(start, closed, LEVELS))[::-1]
    return Stroke(np.array(way), _middles(mechanism, way, pads), pads)


def _follow(mechanism: Mechanism, sides: Sides, parts: Floats) -> list[Floats]:
    """Positions of all joints at fractions of the driven way, from the middle outwards."""
    ranges = mechanism.ranges()
    start = np.where(sides.signs > 0, ranges[:, 0], ranges[:, 1])
    way = sides.signs * np.ptp(ranges, axis=1)
    found: dict[int, Floats] = {}
    half = int(np.abs(parts - 0.5).argmin())
    for numbers in (range(half, len(parts)), range(half, -1, -1)):
        near = mechanism.middle()
        for number in numbers:
            near = mechanism.follow(start + parts[number] * way, near)
            mechanism.check(near)
            found[number] = near
    return [found[number] for number in range(len(parts))]


def _middles(mechanism: Mechanism, way: Sequence[Floats], pads: Pads) -> Floats:
    """The middles of both pads in the frame of the palm, (k, 2, 3)."""
    pairs = list(zip(pads.links, pads.centers, strict=True))
    return np.array(
        [
            [turns[link] @ center + places[link] for link, center in pairs]
            for turns, places in map(mechanism.placement, way)
        ]
    )


def _useful(gaps: Floats, names: str) -> tuple[float, float]:
    """The fractions of the way between which the pads come together, up to where they meet.

    Raises `UserError` if the gaps, metres, at even fractions do not close, or are those of no hand.
    """
    parts, widest = np.linspace(0, 1, len(gaps)), int(gaps.argmax())
    opening = float(gaps[widest])
    if opening < MIN_OPENING:
        raise UserError(f"its links {names} are at most {1000 * max(opening, 0):.2g} mm apart")
    if opening > MAX_OPENING:
        raise UserError(
            f"its links {names} open {opening:.3g} m; limits of sliding joints are in metres"
        )
    last = widest
    while last + 1 < len(gaps) and gaps[last + 1] < gaps[last] and gaps[last] > 0:
        last += 1
    return float(parts[widest]), float(parts[last])
