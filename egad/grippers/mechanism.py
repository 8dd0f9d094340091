"""How the joints of a hand move together: mimic joints, linkages and springs (by MuJoCo)."""

from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Floats = NDArray[np.float64]

# Weights of what a linkage obeys, of its springs, and of staying where it was
CLOSED, SPRINGS, STAYING = 1e3, 1e-2, 1e-5
TIGHT = 1e-14  # relative tolerances
UNLIMITED = 2 * np.pi


class Placement(NamedTuple):
    """Where all links are: (b, 3, 3) rotations and (b, 3) positions in the frame of the palm."""

    turns: Floats
    places: Floats


class Mechanism:
    """The joints of a hand, some of which are driven; the others follow.

    Attributes:
        model: Links, joints and constraints.
        palm: Number of the link that carries the fingers.
        driven: Numbers of the joints that are driven.
        followers: Numbers of those that follow.
    """

    def __init__(
        self, model: mujoco.MjModel, palm: int, driven: list[int], followers: list[int]
    ) -> None:
        """Of a model, with its palm, its joints that are driven and those that follow."""
        self.model, self.palm, self.driven, self.followers = model, palm, driven, followers
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
        self._data = mujoco.MjData(model)
        self._driven_at, self._followers_at = (
            model.jnt_qposadr[driven],
            model.jnt_qposadr[followers],
        )
        self._low, self._high = _limits(model, followers)
        stiffness = np.asarray(model.jnt_stiffness).reshape(model.njnt, -1)[followers, 0]
        self._springs = np.sqrt(stiffness / max(stiffness.max(initial=0.0), 1e-12))
        self._rest = model.qpos_spring[self._followers_at]

    def ranges(self) -> Floats:
        """Limits of the driven joints, (n, 2)."""
        return np.stack(_limits(self.model, self.driven), axis=1)

    def middle(self) -> Floats:
        """Positions of all joints where the driven ones are halfway."""
        return self.follow(self.ranges().mean(axis=1), self.model.qpos0.copy())

    def follow(self, driven: Floats, near: Floats) -> Floats:
        """Positions of all joints for positions of the driven ones.

        The followers obey all constraints between them; what these leave open is decided by the
        springs, as in a hand that touches nothing, and by the limits.

        Args:
            driven: (n,) metres or radians.
            near: Positions of all joints to start from.
        """
        positions = near.copy()
        positions[self._driven_at] = driven
        if not self.followers:
            return positions
        start = np.clip(near[self._followers_at], self._low, self._high)

        def errors(followers: Floats) -> Floats:
            positions[self._followers_at] = followers
            return np.concatenate(
                [
                    CLOSED * self.gaps(positions),
                    SPRINGS * self._springs * (followers - self._rest),
                    STAYING * (followers - start),
                ]
            )

        bounds = (self._low - 1e-9, self._high + 1e-9)
        found = least_squares(errors, start, bounds=bounds, xtol=TIGHT, ftol=TIGHT, gtol=TIGHT)
        positions[self._followers_at] = found.x
        return positions

    def gaps(self, positions: Floats) -> Floats:
        """How far the constraints between joints are violated, metres and radians."""
        self._move(positions)
        kinds = self._data.efc_type[: self._data.nefc]
        equal = kinds == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        return np.asarray(self._data.efc_pos[: self._data.nefc][equal], dtype=np.float64).copy()

    def placement(self, positions: Floats) -> Placement:
        """Where the links are."""
        self._move(positions)
        turns, places = self._data.xmat.reshape(-1, 3, 3), self._data.xpos
        back = turns[self.palm].T
        return Placement(back @ turns, (places - places[self.palm]) @ back.T)

    def axis(self, joint: int, positions: Floats) -> Floats:
        """Axis of a joint in the frame of the palm."""
        self._move(positions)
        back = self._data.xmat[self.palm].reshape(3, 3).T
        return np.asarray(back @ self._data.xaxis[joint])

    def _move(self, positions: Floats) -> None:
        self._data.qpos[:] = positions
        self._data.qvel[:] = 0
        mujoco.mj_fwdPosition(self.model, self._data)


def _limits(model: mujoco.MjModel, joints: list[int]) -> tuple[Floats, Floats]:
    limited = model.jnt_limited[joints].astype(bool)
    low, high = model.jnt_range[joints].T
    return np.where(limited, low, -UNLIMITED), np.where(limited, high, UNLIMITED)
