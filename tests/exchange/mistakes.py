"""Mistakes as people make them, put into what a correct file of grasps holds."""

import numpy as np
from scipy.spatial.transform import Rotation


def turned(axes):
    """A hand whose frame has these columns of the right one."""
    matrix = np.zeros((4, 4))
    matrix[range(3), axes] = 1
    matrix[3, 3] = 1
    if np.linalg.det(matrix) < 0:
        matrix[:, 1] *= -1
    return lambda poses: poses @ matrix


def rolled(poses, step):
    """Quaternions x, y, z, w that are taken for w, x, y, z, or the other way round."""
    quaternions = Rotation.from_matrix(poses[:, :3, :3]).as_quat()
    found = poses.copy()
    found[:, :3, :3] = Rotation.from_quat(np.roll(quaternions, step, axis=1)).as_matrix()
    return found


def with_points(poses, factor):
    found = poses.copy()
    found[:, :3, 3] *= factor
    return found


def moved(poses, depth):
    """Poses of a point further back along z."""
    found = poses.copy()
    found[:, :3, 3] -= depth * poses[:, :3, 2]
    return found


def transposed(poses):
    found = poses.copy()
    found[:, :3, :3] = np.swapaxes(poses[:, :3, :3], 1, 2)
    return found


# by name: what happens to the matrices of a file whose hand approaches along z and closes along x,
# and words of the explanation
MISTAKES = {
    "inverse": (np.linalg.inv, "inverse"),
    "transposed": (lambda poses: np.swapaxes(poses, 1, 2), "the matrices are transposed"),
    "rotations transposed": (transposed, "the rotations are transposed"),
    "quaternion wxyz": (lambda poses: rolled(poses, 1), "quaternions are w, x, y, z"),
    "quaternion xyzw": (lambda poses: rolled(poses, -1), "quaternions are x, y, z, w"),
    "millimetres": (lambda poses: with_points(poses, 1000), "positions are in millimetres"),
    "centimetres": (lambda poses: with_points(poses, 100), "positions are in centimetres"),
    "inches": (lambda poses: with_points(poses, 1 / 0.0254), "positions are in inches"),
    "kilometres": (lambda poses: with_points(poses, 0.001), "positions were divided by 1000"),
    "axes yz": (turned([1, 0, 2]), "closes along y and approaches along z"),
    "axes zx": (turned([2, 1, 0]), "closes along -?z and approaches along x"),
    "axes xy": (turned([0, 2, 1]), "closes along x and approaches along -?y"),
    "reversed": (lambda poses: poses @ np.diag([1.0, -1, -1, 1]), "approaches along -z"),
    "mirrored hand": (lambda poses: poses @ np.diag([1.0, -1, 1, 1]), "hand is mirrored"),
    "deeper": (lambda poses: moved(poses, 0.1), "of the base of the hand"),
    "not deep": (lambda poses: moved(poses, -0.1), "of the contacts"),
    "axes zx, deeper": (
        lambda poses: turned([2, 1, 0])(moved(poses, 0.1)),
        "closes along -?z and approaches along x, and the poses are of the base",
    ),
    "y up": (
        lambda poses: turn_x(-90) @ poses,
        "^y of the object is up",
    ),
    "-y up": (lambda poses: turn_x(90) @ poses, "^-y of the object is up"),
    "mirrored object": (
        lambda poses: np.diag([1.0, -1, 1, 1]) @ poses @ np.diag([1.0, -1, 1, 1]),
        "the object is mirrored: its y",
    ),
}


def turn_x(angle):
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("x", angle, degrees=True).as_matrix()
    return matrix
