"""How a solid comes to rest on a table."""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import QhullError

from egad.errors import RejectedError

Floats = NDArray[np.float64]


class StablePose(NamedTuple):
    """A face of the convex hull that a solid rests on.

    Attributes:
        probability: That it comes to rest on this face when it is dropped at random.
        rotation: (3, 3), from the object's frame to the table's, whose z points upwards.
        point: (3,) a vertex that touches the table, in the object's frame, metres.
    """

    probability: float
    rotation: Floats
    point: Floats


def stable_poses(mesh: trimesh.Trimesh, com: Floats, least: float) -> list[StablePose]:
    """The stable poses of a solid, the most likely first; one for each face it can rest on.

    Triangles of the hull that lie in one plane are one face. (Dex-Net lists each of them.)

    Args:
        mesh: The solid, metres.
        com: (3,) its centre of mass, metres.
        least: Poses less likely than this are left out.

    Raises:
        RejectedError: The solid is flat, or its centre of mass is not inside its convex hull.

    Source: trimesh, after Goldberg et al., Part pose statistics, 1999. Probabilities are the solid
    angles from which the faces are seen, handed on along the way that the solid topples.
    """
    corners = _hull_around(mesh, com)
    transforms, probabilities = trimesh.poses.compute_stable_poses(
        mesh, center_mass=com, sigma=0, n_samples=1, threshold=least
    )
    poses = []
    for transform, probability in zip(transforms, probabilities, strict=True):
        rotation = np.asarray(transform, dtype=np.float64)[:3, :3]
        lowest = corners[np.argmin(corners @ rotation[2])]
        poses.append(StablePose(float(probability), rotation, lowest))
    return sorted(poses, key=lambda pose: -pose.probability)


def _hull_around(mesh: trimesh.Trimesh, com: Floats) -> Floats:
    """Vertices of the convex hull; trimesh's search would not end for a point that is not inside.

    This is the same comparison as trimesh's, which a triangle without area always fails.
    """
    try:
        hull = mesh.convex_hull
    except QhullError as error:
        raise RejectedError("the solid is flat") from error
    heights = np.einsum("ij,ij->i", com - hull.triangles_center, hull.face_normals)
    if len(heights) == 0 or not (heights < 0).all():
        raise RejectedError(
            "its centre of mass is not inside its convex hull, or the hull has an empty triangle"
        )
    return np.asarray(hull.vertices, dtype=np.float64)
