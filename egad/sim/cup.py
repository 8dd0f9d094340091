"""A suction cup in a world: it approaches until its ring lies on an object; if it seals, it holds.

The stem collides like any body; the cup is soft, and neither pushes nor is pushed. Whether it seals
is computed from the true surfaces, at the poses in the simulation. The object that it seals on is
then held as long as the load stays within the limits of the cup (`World.attach`).
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from typing_extensions import override

from egad._util.arrays import Floats
from egad.geometry import RayCaster, joined
from egad.grasps.suction import Seals, ring_depths, seal_cups
from egad.grippers import SuctionCup, cup_of
from egad.grippers.kinds import CupKind, JawKind
from egad.sim.jaws import Fingers, FreeHand, Hand
from egad.sim.world import TIME_STEP
from egad.tables.outcomes import Outcome

EVACUATION_TIME = 0.1  # seconds that the cup rests on an object before it holds it
PRESS = 0.001  # metres that the ring is pressed beyond where it lies on an object


class Cup(Fingers):
    """A suction cup in place of fingers."""

    _seeks = True

    @cached_property
    def cup(self) -> SuctionCup:
        """The cup."""
        return cup_of(self.gripper, "a vacuum")

    @override
    def arrives(self) -> bool:
        return self._seeks and self._depth() <= -PRESS

    @override
    def close(self) -> bool:
        """Switch the vacuum on, which holds the object that the cup seals on, if it does."""
        self._seeks = False
        self.world.step(round(EVACUATION_TIME / TIME_STEP))
        found = {number: self._seal(number) for number in self.world.present()}
        sealed = {n: float(seal.depths[0]) for n, seal in found.items() if seal.sealed[0]}
        if not sealed:
            return False
        number = min(sealed, key=sealed.__getitem__)
        if sealed[number] > 0 or not (len(found) == 1 or self._seals_among(list(found))):
            return False
        self.world.attach(number, sealed[number])
        return True

    @override
    def pinches(self) -> bool:
        """Whether the cup holds an object."""
        return self.world.attached is not None

    @override
    def carries(self) -> bool:
        return self.pinches() and not self.world.forces().support > 0

    @override
    def opening(self) -> float:
        return 0.0

    @override
    def loss(self, touched: bool) -> Outcome:
        return Outcome.SLIPPED_LIFTING if touched else Outcome.NO_SEAL

    def _depth(self) -> float:
        """Mean depth of the ring where it meets any object, metres; infinite if it misses."""
        rings = [
            ring_depths(self.world.caster(number), self.cup, *self._frame(number))
            for number in self.world.present()
        ]
        return float(np.min(rings, axis=0).mean()) if rings else np.inf

    def _seal(self, number: int) -> Seals:
        return seal_cups(self.world.caster(number), self.cup, *self._frame(number))

    def _seals_among(self, numbers: Sequence[int]) -> bool:
        """Whether the cup seals with all objects around it as one body."""
        meshes = []
        for number in numbers:
            mesh = self.world.models[number].mesh
            meshes.append(mesh.copy().apply_transform(self.world.pose(number).matrix))
        whole = RayCaster(joined(meshes))
        return bool(seal_cups(whole, self.cup, *_frame_of(self.world.cup_pose())).sealed[0])

    def _frame(self, number: int) -> tuple[Floats, Floats]:
        """Origin (1, 3) and unit vectors (1, 3, 3) of the cup, seen from an object."""
        matrix = self.world.pose(number).matrix
        return _frame_of(np.linalg.inv(matrix) @ self.world.cup_pose())


class CupHand(Cup, Hand):
    """A suction cup on a stem, carried by an arm."""

    @override
    def _lift_from(self) -> float:
        # An arm that sags would jerk if the lift began at its actual height.
        return self._hand_pose.height


class FreeCup(Cup, FreeHand):
    """A suction cup that moves along straight lines without turning."""

    @override
    def held(self, *, first: bool = False) -> int | None:
        del first
        return self.world.attached


# Hands by the kind of gripper: carried by an arm, or without one
ON_ARM = {JawKind.name: Hand, CupKind.name: CupHand}
FREE = {JawKind.name: FreeHand, CupKind.name: FreeCup}


def _frame_of(pose: Floats) -> tuple[Floats, Floats]:
    return pose[None, :3, 3], np.ascontiguousarray(pose[None, :3, :3].transpose(0, 2, 1))
