"""Grasp rectangles in an image: projected from grasps in 3D, and compared with each other.

Rectangles are rows of an array (n, 5): u and v of the center, pixels, pixel (0, 0) having its
center at 0, 0; the angle of the closing axis, radians counterclockwise as seen from the image's x
axis, in [-pi/2, pi/2); the opening along that axis and the breadth of the jaws across it, pixels.
"""

from typing import Any, NamedTuple

import numpy as np
from manifold3d import CrossSection
from numpy.typing import NDArray

from egad._util.arrays import Flags, Floats, Ints
from egad.grasps import roomy
from egad.grippers import Gripper
from egad.learning.images.arrangement import TableGrasps
from egad.learning.images.viewpoints import CameraScene

Rectangles = NDArray[np.float64]
MIN_OVERLAP = 0.25
MAX_TURN = np.pi / 6


class ImageGrasps(NamedTuple):
    """Grasps in an image; pixels, see above."""

    object: Ints  # (n,) numbers of the objects in the image, from 0
    u: Floats  # (n,) column of the center
    v: Floats  # (n,) row of the center
    angle: Floats  # (n,) of the closing axis, radians in [-pi/2, pi/2)
    opening: Floats  # (n,) how far the hand opens, at the depth of the center
    depth_center: Floats  # (n,) of the center, along the optical axis, metres
    quality: Floats  # (n,) robust quality; 0 for those that are not free of collisions
    collision_free: Flags  # (n,) whether the hand touches nothing but the contacts
    # (n,) whether the grasp held in simulation; None if it was not simulated
    simulated_success: NDArray[np.object_]

    def chosen(self, which: Flags | Ints) -> "ImageGrasps":
        """Some of them."""
        return ImageGrasps(*(values[which] for values in self))  # type: ignore[arg-type]

    def ends(self) -> Floats:
        """Both ends of each opening, pixels, (n, 2, 2) u and v."""
        half = self.opening / 2
        along = np.stack([np.cos(self.angle) * half, -np.sin(self.angle) * half], axis=1)
        middle = np.stack([self.u, self.v], axis=1)
        return np.stack([middle - along, middle + along], axis=1)


def project_grasps(scene: CameraScene, grasps: TableGrasps, gripper: Gripper) -> ImageGrasps:
    """Grasps in the image of a scene; those whose centers are outside it are left out."""
    matrix, camera = np.linalg.inv(scene.camera) @ scene.matrix, scene.intrinsics
    centers = grasps.centers @ matrix[:3, :3].T + matrix[:3, 3]
    aside = grasps.widths[:, None] / 2 * (grasps.axes @ matrix[:3, :3].T)
    u, v = camera.pixels(centers).T
    right, down = (camera.pixels(centers + aside) - camera.pixels(centers - aside)).T
    found = ImageGrasps(
        object=grasps.objects,
        u=u,
        v=v,
        angle=half_turn(np.arctan2(-down, right)),
        opening=roomy(grasps.widths, gripper) * camera.focal / centers[:, 2],
        depth_center=centers[:, 2],
        quality=grasps.qualities,
        collision_free=grasps.free,
        simulated_success=grasps.success,
    )
    inside = (np.abs(u - (camera.width - 1) / 2) <= camera.width / 2) & (
        np.abs(v - (camera.height - 1) / 2) <= camera.height / 2
    )
    return found.chosen(inside)


def half_turn(angle: Any) -> Any:  # noqa: ANN401 (a number or an array)
    """Angles of axes, which have no direction, in [-pi/2, pi/2), radians."""
    within = (angle + np.pi / 2) % np.pi - np.pi / 2
    return np.where(within >= np.pi / 2, -np.pi / 2, within)


def agrees(proposed: NDArray[np.float64], truth: Rectangles) -> bool:
    """Whether (u, v, angle, opening) is as good as a label of (n, 5), by the usual score.

    Jiang, Moseson and Saxena, ICRA 2011: overlap above 0.25, axes less than 30 degrees apart. The
    breadth of the jaws is that of the label (ours; GG-CNN takes half of the opening).
    """
    near = truth[np.abs(half_turn(truth[:, 2] - proposed[2])) < MAX_TURN]
    return any(overlap(np.append(proposed, row[4]), row) > MIN_OVERLAP for row in near)


def overlap(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Intersection over union of two rectangles (5,); corners are rounded to 1e-8 pixels."""
    first, second = (
        CrossSection.square((opening, breadth), True).rotate(-np.degrees(angle)).translate((u, v))
        for u, v, angle, opening, breadth in (one, other)  # v points down
    )
    common: float = (first ^ second).area()
    return common / (first.area() + second.area() - common) if common else 0.0
