"""Ferrari-Canny quality of two-finger grasps with soft fingers.

Ferrari and Canny, "Planning optimal grasps", ICRA 1992, with the L1 norm: the largest disturbance
that the fingers can resist in every direction while their contact forces add up to one. The contact
model and its constants are those of Dex-Net 2.0 (Mahler et al., RSS 2017).
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from egad._util.arrays import Floats
from egad._util.kernels import kernel
from egad.grasps.wrench_hull import depths

CONE_FACES = 8
ROUNDING = 1e-9  # relative: bounds are larger by this


def ferrari_canny(
    points: ArrayLike,
    normals: ArrayLike,
    axis: ArrayLike,
    com: ArrayLike,
    *,
    friction: ArrayLike = 0.5,
    torque_scaling: float = 100.0,
    finger_radius: float = 0.005,
    cone_faces: int = CONE_FACES,
    floor: float = 0.0,
) -> Floats:
    """Quality of each of n grasps: 0 is useless, larger is better.

    The value is exact: the smallest distance from the origin to a facet of the convex hull of all
    wrenches; 0 if the origin is not strictly inside, or if a finger slips because the angle
    between the axis and its normal exceeds the friction angle. With `a` that angle and `d` the
    distance of the center of mass from the line of contacts, the quality is at most
    `pi finger_radius^2 friction torque_scaling cos(a)^2 / sqrt(1 + (torque_scaling d)^2)` for the
    better of the two contacts.

    Args:
        points: (n, 2, 3) contacts, metres.
        normals: (n, 2, 3) outward unit normals there.
        axis: (n, 3) unit vectors from the first contact to the second.
        com: (3,) or (n, 3) center of mass, metres.
        friction: Coulomb friction coefficient, one for all or (n,).
        torque_scaling: Weight of a torque relative to a force, 1/m.
        finger_radius: Radius of the soft contact, metres; it resists torsion.
        cone_faces: Edges of a linearized friction cone, 3 to 28.
        floor: A quality below this may be replaced by an upper bound that is also below it; this
            saves time.

    Returns:
        (n,) qualities.
    """
    points = np.asarray(points, dtype=float).reshape(-1, 2, 3)
    normals = np.asarray(normals, dtype=float).reshape(-1, 2, 3)
    axis = np.asarray(axis, dtype=float).reshape(-1, 3)
    arms = points - np.broadcast_to(com, axis.shape)[:, None]
    mu = np.broadcast_to(np.asarray(friction, dtype=float), len(points))
    held = np.flatnonzero(~slips(normals, axis, mu))
    quality = np.zeros(len(points))
    quality[held] = depths(
        wrenches(
            torque_scaling * arms[held],
            normals[held],
            axis[held],
            mu[held],
            torque_scaling * np.pi * finger_radius**2,
            cone_faces,
        ),
        floor,
    )
    return quality


def quality_bound(
    points: Floats,
    normals: Floats,
    axis: Floats,
    com: Floats,
    *,
    friction: float = 0.5,
    torque_scaling: float = 100.0,
    finger_radius: float = 0.005,
) -> Floats:
    """An upper bound of `ferrari_canny` in closed form, (n,); 0 where a finger slips (ours).

    Only torsion turns the object about the line of contacts, by at most
    `pi finger_radius^2 friction torque_scaling cos(a)^2`; `d` from the center of mass, the wrench
    against it has the length `sqrt(1 + (torque_scaling d)^2)`.
    """
    pressure = pressures(normals, axis)
    torsion = np.pi * finger_radius**2 * friction * torque_scaling * pressure.max(axis=1) ** 2
    levers = torque_scaling * np.cross(points[:, 0] - com, axis)
    bound = torsion / np.sqrt(1 + np.einsum("nk,nk->n", levers, levers))
    held = ~slips(normals, axis, np.full(len(axis), friction))
    return np.where(held, bound * (1 + ROUNDING), 0.0)


def slips(normals: Floats, axis: Floats, friction: Floats) -> NDArray[np.bool_]:
    """Which of n grasps have a contact with the axis outside its friction cone."""
    held = pressures(normals, axis).min(axis=1) >= 1 / np.sqrt(1 + friction**2)
    return np.asarray(~held)  # NaN slips


def pressures(normals: Floats, axis: Floats) -> Floats:
    """Part of a unit closing force that presses along each inward normal: (n, 2)."""
    signs = np.array([-1.0, 1.0])
    return np.asarray(signs * np.einsum("nck,nk->nc", normals, axis))


def wrenches(
    arms: Floats, normals: Floats, axis: Floats, friction: Floats, torsion: float, cone_faces: int
) -> Floats:
    """Force and scaled torque that contacts of n grasps can apply, (n, 2 cone_faces + 4, 6).

    Each finger presses with a unit force along its inward normal; the first edge of its cone leans
    to x; torsion is per friction and pressure. `arms` (n, 2, 3) are times the torque scaling.
    """
    angles = 2 * np.pi * np.arange(cone_faces) / cone_faces
    result: Floats = _wrenches(
        arms, normals, axis, friction, torsion, np.cos(angles), np.sin(angles)
    )
    return result


@kernel()
def _wrenches(
    arms: Floats,
    normals: Floats,
    axis: Floats,
    friction: Floats,
    torsion: float,
    cosine: Floats,
    sine: Floats,
) -> Floats:
    faces = len(cosine)
    result = np.zeros((len(arms), 2 * faces + 4, 6))
    tangent, other, force = np.empty(3), np.empty(3), np.empty(3)
    for i in range(len(arms)):
        for c in range(2):
            normal, arm = normals[i, c], arms[i, c]
            pressure = normal[0] * axis[i, 0] + normal[1] * axis[i, 1] + normal[2] * axis[i, 2]
            pressure *= 2 * c - 1
            _frame(normal, tangent, other)
            for j in range(faces):
                for k in range(3):
                    lean = cosine[j] * tangent[k] + sine[j] * other[k]
                    force[k] = lean * (friction[i] * pressure) - normal[k] * pressure
                for k in range(3):
                    m, n = (k + 1) % 3, (k + 2) % 3
                    result[i, c * faces + j, k] = force[k]
                    result[i, c * faces + j, 3 + k] = arm[m] * force[n] - arm[n] * force[m]
            for k in range(3):
                twist = torsion * friction[i] * normal[k] * pressure
                result[i, 2 * faces + c, 3 + k] = -twist
                result[i, 2 * faces + 2 + c, 3 + k] = twist
    return result


@kernel()
def _frame(normal: Floats, tangent: Floats, other: Floats) -> None:
    """Fill in the unit tangent nearest to x, or to y if the normal is along x, and their cross."""
    axis = 1 if abs(normal[0]) > 1 - 1e-9 else 0
    length = 0.0
    for k in range(3):
        tangent[k] = (k == axis) - normal[axis] * normal[k]
        length += tangent[k] ** 2
    for k in range(3):
        tangent[k] /= np.sqrt(length)
    for k in range(3):
        m, n = (k + 1) % 3, (k + 2) % 3
        other[k] = normal[m] * tangent[n] - normal[n] * tangent[m]
