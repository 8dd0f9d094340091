"""The links and joints of a hand, and how they move together: mimic joints, linkages, springs."""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from egad._util.arrays import Floats
from egad.errors import UserError

MOVING = {int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE)}


def body_name(model: mujoco.MjModel, body: int) -> str:
    """Name of a link."""
    return str(model.body(body).name)


def joint_name(model: mujoco.MjModel, joint: int) -> str:
    """Name of a joint."""
    return str(model.joint(joint).name)


def link_number(model: mujoco.MjModel, name: str) -> int:
    """Number of a link, or `UserError`."""
    names = [body_name(model, body) for body in range(model.nbody)]
    if name not in names:
        raise UserError(f"it has no link {name!r}; it has {', '.join(names[1:])}")
    return names.index(name)


def moving_joints(model: mujoco.MjModel) -> list[int]:
    """Numbers of the joints that slide or turn."""
    return [joint for joint in range(model.njnt) if int(model.jnt_type[joint]) in MOVING]


def subtree(model: mujoco.MjModel, body: int) -> set[int]:
    """A link and all that it carries."""
    carried = {body}
    for other in range(body + 1, model.nbody):  # parents come first
        if model.body_parentid[other] in carried:
            carried.add(other)
    return carried


def ancestors(model: mujoco.MjModel, body: int) -> list[int]:
    """A link, what carries it, and so on to the root."""
    chain = [body]
    while chain[-1]:
        chain.append(int(model.body_parentid[chain[-1]]))
    return chain


def find_palm(model: mujoco.MjModel, fingers: Sequence[str] | None = None) -> tuple[int, list[int]]:
    """The link that carries the fingers, or all behind an arm, and the links on it that move."""
    if fingers is not None:
        first, second = (ancestors(model, link_number(model, name)) for name in fingers)
        common = [body for body in first if body in second]
        palm = max(common)
    else:
        palm = 0
        while len(chains := _moving_children(model, palm)) == 1:
            if not _moving_children(model, chains[0]):
                break
            palm = chains[0]
    chains = _moving_children(model, palm)
    if not chains:
        raise UserError("none of its joints moves")
    return palm, chains


def hand_bodies(model: mujoco.MjModel, palm: int) -> list[int]:
    """Numbers of the palm, of what it carries, and of what is fixed behind it."""
    behind, body = [], palm
    while body and not model.body_jntnum[body]:
        body = int(model.body_parentid[body])
        behind.append(body)
    return [palm, *sorted(subtree(model, palm) - {palm}), *(each for each in behind if each)]


def _moving_children(model: mujoco.MjModel, body: int) -> list[int]:
    moving = {int(model.jnt_bodyid[joint]) for joint in moving_joints(model)}
    children = [other for other in range(1, model.nbody) if model.body_parentid[other] == body]
    return [child for child in children if moving & subtree(model, child)]


# Weights of the constraints of a linkage, of its springs, and of staying where it was
CLOSED, SPRINGS, STAYING = 1e3, 1e-2, 1e-5
TIGHT = 1e-14  # relative tolerances
LOOSE = 1e-4  # metres or radians by which joints may miss a constraint
UNLIMITED = 2 * np.pi


class Placement(NamedTuple):
    """Where all links are: (b, 3, 3) rotations and (b, 3) positions in the frame of the palm."""

    turns: Floats
    places: Floats


class Mechanism:
    """The joints of a hand, some of which are driven; the others follow."""

    def __init__(
        self, model: mujoco.MjModel, palm: int, driven: list[int], followers: list[int]
    ) -> None:
        """Take a model, its palm, the joints that are driven and those that follow."""
        self.model, self.palm, self.driven, self.followers = model, palm, driven, followers
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
        self._data = mujoco.MjData(model)
        self._driven_at, self._followers_at = (
            model.jnt_qposadr[driven],
            model.jnt_qposadr[followers],
        )
        # A joint that mimics another one goes wherever that one takes it, as in the tools of ROS.
        mimics = np.isin(followers, list(coupled_joints(model)))
        ends = np.array([[-np.inf], [np.inf]])
        self._low, self._high = np.where(mimics, ends, _limits(model, followers))
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
        """Positions of all joints for (n,) driven ones; springs and limits decide what is open."""
        positions = near.copy()
        positions[self._driven_at] = driven
        if not self.followers:
            return positions
        start = np.clip(near[self._followers_at], self._low, self._high)

        def errors(moves: Floats) -> Floats:
            positions[self._followers_at] = start + moves
            return np.concatenate(
                [
                    CLOSED * self._gaps(positions),
                    SPRINGS * self._springs * (start + moves - self._rest),
                    STAYING * moves,
                ]
            )

        # Moves, not positions: the first step of the solver is as long as its starting point, so it
        # stops at once near 0, but not at 0 itself.
        bounds = (self._low - start - 1e-9, self._high - start + 1e-9)
        found = least_squares(
            errors, np.zeros_like(start), bounds=bounds, xtol=TIGHT, ftol=TIGHT, gtol=TIGHT
        )
        positions[self._followers_at] = start + found.x
        return positions

    def holds(self, positions: Floats) -> bool:
        """Whether all constraints between joints hold."""
        return bool(np.abs(self._gaps(positions)).max(initial=0.0) <= LOOSE)

    def check(self, positions: Floats) -> None:
        """Raise UserError, with the joints or links, if a constraint does not hold."""
        if self.holds(positions):
            return
        gaps = np.abs(self._gaps(positions))
        worst = int(self._data.efc_id[self._equalities()][gaps.argmax()])
        driven = ", ".join(
            f"{joint_name(self.model, joint)} is at {position:.4g}"
            for joint, position in zip(self.driven, positions[self._driven_at], strict=True)
        )
        raise UserError(
            f"where {driven}, the coupling of the {_coupling(self.model, worst)} does not hold; it "
            f"is off by {gaps.max():.2g} metres or radians"
        )

    def joints_beyond_limits(self, way: Floats) -> list[str]:
        """Names of the followers that go beyond their own limits on a way (k, q)."""
        low, high = self.model.jnt_range[self.followers].T
        there = way[:, self._followers_at]
        beyond = ((there < low - LOOSE) | (there > high + LOOSE)).any(axis=0)
        beyond &= self.model.jnt_limited[self.followers].astype(bool)
        return [joint_name(self.model, self.followers[each]) for each in np.flatnonzero(beyond)]

    def _gaps(self, positions: Floats) -> Floats:
        """How far the constraints between joints are violated, metres and radians."""
        self._move(positions)
        return np.array(self._data.efc_pos[self._equalities()], dtype=np.float64)

    def _equalities(self) -> NDArray[np.bool_]:
        """Which rows of the constraints are those between joints or links."""
        return np.asarray(self._data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)

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

    def velocities(self, positions: Floats, body: int, points: Floats) -> tuple[Floats, Floats]:
        """Velocities (n, 3) of points per radian or metre of the joint, and levers (n,), metres."""
        joint = int(self.model.body_jntadr[body])
        axis = self.axis(joint, positions)
        if self.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE:
            return np.tile(axis, (len(points), 1)), np.ones(len(points))
        velocities = np.cross(axis, points - self.anchor(joint, positions))
        return velocities, np.linalg.norm(velocities, axis=1)

    def anchor(self, joint: int, positions: Floats) -> Floats:
        """A point of the axis of a joint in the frame of the palm, metres."""
        self._move(positions)
        back = self._data.xmat[self.palm].reshape(3, 3).T
        return np.asarray(back @ (self._data.xanchor[joint] - self._data.xpos[self.palm]))

    def _move(self, positions: Floats) -> None:
        self._data.qpos[:] = positions
        self._data.qvel[:] = 0
        mujoco.mj_fwdPosition(self.model, self._data)


def coupled_joints(model: mujoco.MjModel) -> set[int]:
    """Joints of which one is a function of the other."""
    pairs = (model.eq_type == mujoco.mjtEq.mjEQ_JOINT) & (model.eq_obj2id >= 0)
    return set(map(int, np.concatenate([model.eq_obj1id[pairs], model.eq_obj2id[pairs]])))


def _coupling(model: mujoco.MjModel, equality: int) -> str:
    """What a constraint couples: names of joints, tendons or links."""
    ends = [int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])]
    ends = [each for each in ends if each >= 0]
    kind = model.eq_type[equality]
    if kind == mujoco.mjtEq.mjEQ_JOINT:
        return "joints " + " and ".join(joint_name(model, each) for each in ends)
    if kind == mujoco.mjtEq.mjEQ_TENDON:
        return "tendons " + " and ".join(model.tendon(each).name for each in ends)
    if model.eq_objtype[equality] == mujoco.mjtObj.mjOBJ_SITE:
        ends = [int(model.site_bodyid[each]) for each in ends]
    return "links " + " and ".join(body_name(model, each) for each in ends)


def _limits(model: mujoco.MjModel, joints: list[int]) -> tuple[Floats, Floats]:
    limited = model.jnt_limited[joints].astype(bool)
    low, high = model.jnt_range[joints].T
    return np.where(limited, low, -UNLIMITED), np.where(limited, high, UNLIMITED)
