"""Whether suction cups seal against a surface: the springs of Dex-Net 3.0 (Mahler et al. 2018).

The frame of a cup has its origin in the middle of the ring, before the ring is deformed. z is the
approach, into the object; x points to the first vertex of the ring. Depths count along z.
"""

from enum import StrEnum
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from egad._util.arrays import Flags, Floats, Ints
from egad.geometry import RayCaster
from egad.grippers import SuctionCup

HOLE_POINTS = 50  # points within the ring that are checked for holes; as in GraspGen
GOLDEN_RATIO = (1 + np.sqrt(5)) / 2
INNER = 1e-9  # least share of the apex in a point of the wall


class SealFailure(StrEnum):
    """Why a cup does not seal."""

    MISSED = "ring misses the object"
    BLOCKED = "object in the way of the cup"
    STRAINED = "ring bent too far"
    HOLE = "hole inside the ring"
    WALL = "object meets the wall of the cup"


class Seals(NamedTuple):
    """How n cups meet an object."""

    failures: NDArray[np.str_]  # (n,) texts of `SealFailure`; empty if the cup seals
    strains: Floats  # (n,) largest relative change of length of a spring; infinite if it misses
    depths: Floats  # (n,) mean depth of the ring, metres; infinite if it misses

    @property
    def sealed(self) -> Flags:
        """(n,) whether each cup seals."""
        return np.asarray(self.failures == "")


class Springs(NamedTuple):
    """Lengths of the springs of n cups, (n, sides) each, metres."""

    perimeter: Floats  # from each vertex of the ring to the next
    flexion: Floats  # from each vertex of the ring to the next but one
    cone: Floats  # from each vertex of the ring to the apex


def seal_cups(caster: RayCaster, cup: SuctionCup, origins: Floats, frames: Floats) -> Seals:
    """Move cups onto an object and check whether they seal.

    Ring vertices move along z to the object. A cup seals if every spring stays below `max_strain`,
    no ray inside the ring meets a hole (nothing, or deeper than the cup is high), and the surface
    stays below the wall of the cup.
    """
    ring = ring_depths(caster, cup, origins, frames)
    met = np.isfinite(ring).all(axis=1)
    ring[~met] = 0.0
    mean = ring.mean(axis=1)
    rest, springs = spring_lengths(cup, np.zeros((1, cup.sides))), spring_lengths(cup, ring)
    strains = np.max(np.abs(np.stack(springs) / np.stack(rest) - 1), axis=(0, 2))
    failures = np.select(
        [~met, mean < -cup.height, strains >= cup.max_strain],
        [SealFailure.MISSED, SealFailure.BLOCKED, SealFailure.STRAINED],
        " " * len(SealFailure.WALL),
    )
    failures = np.char.strip(failures)
    good = np.flatnonzero(failures == "")
    failures[good] = _failures_within(caster, cup, origins[good], frames[good], ring[good])
    return Seals(failures, np.where(met, strains, np.inf), np.where(met, mean, np.inf))


def ring_depths(caster: RayCaster, cup: SuctionCup, origins: Floats, frames: Floats) -> Floats:
    """Depths (n, sides) at which the rings of n cups meet an object, metres; infinite if not."""
    return _depths(caster, cup, origins, frames, ring_vertices(cup))


def ring_vertices(cup: SuctionCup) -> Floats:
    """(sides, 2) vertices of the ring before it is deformed, x and y, metres."""
    angles = 2 * np.pi * np.arange(cup.sides) / cup.sides
    return cup.radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def spring_lengths(cup: SuctionCup, ring: Floats) -> Springs:
    """Lengths of the springs of cups with vertices at these depths, (n, sides), metres."""
    chords = 2 * cup.radius * np.sin(np.pi * np.array([1, 2]) / cup.sides)
    heights = cup.height + ring - ring.mean(axis=1, keepdims=True)
    return Springs(
        np.hypot(chords[0], ring - np.roll(ring, -1, axis=1)),
        np.hypot(chords[1], ring - np.roll(ring, -2, axis=1)),
        np.hypot(cup.radius, heights),
    )


def _failures_within(
    caster: RayCaster, cup: SuctionCup, origins: Floats, frames: Floats, ring: Floats
) -> NDArray[np.str_]:
    """What fails inside the ring of each of n cups, given the depths of the ring (n, sides)."""
    points, sectors, shares = _points_within(cup)
    depths = _depths(caster, cup, origins, frames, points)
    mean = ring.mean(axis=1, keepdims=True)
    apex = mean - cup.height
    wall = shares[:, 0] * ring[:, sectors] + shares[:, 1] * ring[:, (sectors + 1) % cup.sides]
    wall += shares[:, 2] * apex
    hole = (depths - mean > cup.height).any(axis=1)
    above = ((depths < wall) & (shares[:, 2] > INNER)).any(axis=1)
    found = [SealFailure.HOLE.value, SealFailure.WALL.value]
    return np.select([hole, above], found, "")


@lru_cache(maxsize=8)
def _points_within(cup: SuctionCup) -> tuple[Floats, Ints, Floats]:
    """Sunflower points (k, 2) in the ring, metres; (k,) the first vertex of each one's sector.

    And (k, 3) shares of this vertex, the next and the apex: negative between ring and chord.
    """
    number = np.arange(1, HOLE_POINTS + 1)
    outer = round(2 * np.sqrt(HOLE_POINTS))
    parts = np.sqrt((number - 0.5) / (HOLE_POINTS - (outer + 1) / 2))
    reach = cup.radius * np.where(number > HOLE_POINTS - outer, 1.0, parts)
    angles = 2 * np.pi * number / GOLDEN_RATIO**2 % (2 * np.pi)
    points = reach[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    sector = 2 * np.pi / cup.sides
    sectors = np.floor(angles / sector).astype(np.int64) % cup.sides
    inside = angles - sectors * sector
    scale = reach / (cup.radius * np.sin(sector))
    first, second = scale * np.sin(sector - inside), scale * np.sin(inside)
    return points, sectors, np.stack([first, second, 1 - first - second], axis=1)


def _depths(
    caster: RayCaster, cup: SuctionCup, origins: Floats, frames: Floats, points: Floats
) -> Floats:
    """Depths (n, k), metres, of points (k, 2) of n cups on the object; infinite if not outside."""
    x, y, z = frames[:, None, 0], frames[:, None, 1], frames[:, None, 2]
    starts = origins[:, None] - cup.approach * z + points[:, :1] * x + points[:, 1:] * y
    directions = np.broadcast_to(z, starts.shape)
    hits = caster.first_hits(starts.reshape(-1, 3), directions.reshape(-1, 3))
    depths = np.where(hits.entering, hits.distances - cup.approach, np.inf)
    return depths.reshape(len(origins), len(points))
