"""Where grasps are in an image, as rectangles: centre, angle, opening."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from egad.grasps.room import roomy
from egad.settings import Gripper
from egad.vision.reach import Grasped
from egad.vision.rectangles import half_turn
from egad.vision.scenes import Scene

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]


class ImageGrasps(NamedTuple):
    """Grasps in an image; pixel (0, 0) has its centre at u = v = 0.

    Attributes:
        grasp: (n,) numbers of the labels.
        u: (n,) column of the centre, pixels.
        v: (n,) row of the centre, pixels.
        angle: (n,) of the closing axis, anticlockwise as seen in the image, from its x axis
            (right), radians in [-pi/2, pi/2).
        opening: (n,) how far the hand opens, at the depth of the centre, pixels.
        depth_center: (n,) of the centre, along the optical axis, metres.
        quality: (n,).
        free: (n,) whether the hand touches neither object nor table.
    """

    grasp: Ints
    u: Floats
    v: Floats
    angle: Floats
    opening: Floats
    depth_center: Floats
    quality: Floats
    free: Flags

    def chosen(self, which: Flags | Ints) -> "ImageGrasps":
        """Some of them."""
        return ImageGrasps(*(values[which] for values in self))  # type: ignore[arg-type]

    def ends(self) -> Floats:
        """Both ends of each opening, pixels, (n, 2, 2) u and v."""
        half = self.opening / 2
        along = np.stack([np.cos(self.angle) * half, -np.sin(self.angle) * half], axis=1)
        middle = np.stack([self.u, self.v], axis=1)
        return np.stack([middle - along, middle + along], axis=1)


def projected(scene: Scene, grasps: Grasped, free: Flags, gripper: Gripper) -> ImageGrasps:
    """Grasps in the image of a scene; those whose centres are beside it are left out.

    Args:
        scene: Object and camera.
        grasps: In the frame of the mesh.
        free: (n,) which of them are free.
        gripper: The hand, for how far it opens.
    """
    matrix, camera = np.linalg.inv(scene.camera) @ scene.matrix, scene.intrinsics
    centers = grasps.centers @ matrix[:3, :3].T + matrix[:3, 3]
    aside = grasps.widths[:, None] / 2 * (grasps.axes @ matrix[:3, :3].T)
    u, v = camera.pixels(centers).T
    right, down = (camera.pixels(centers + aside) - camera.pixels(centers - aside)).T
    found = ImageGrasps(
        grasp=grasps.numbers,
        u=u,
        v=v,
        angle=half_turn(np.arctan2(-down, right)),
        opening=roomy(grasps.widths, gripper) * camera.focal / centers[:, 2],
        depth_center=centers[:, 2],
        quality=grasps.qualities,
        free=free,
    )
    inside = (np.abs(u - (camera.width - 1) / 2) <= camera.width / 2) & (
        np.abs(v - (camera.height - 1) / 2) <= camera.height / 2
    )
    return found.chosen(inside)
