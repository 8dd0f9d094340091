"""Pictures of labelled scenes: shaded depth, objects in colors, and the hand at its grasps."""

import io

import numpy as np
from PIL import Image, ImageDraw

from egad._util.arrays import Floats, RgbImage
from egad.detectors import View
from egad.grippers import Gripper, finger_span
from egad.learning.scenes.reading import LabelledScene

COLORS = np.array(
    [[78, 121, 167], [242, 142, 43], [118, 183, 178], [237, 201, 72], [176, 122, 161]]
)
TABLE = np.array([205, 205, 205])
HELD, FAILED = (30, 150, 60), (200, 40, 40)
MAX_SHOWN = 10  # grasps of each label that are drawn
SIZE = (640, 480)
MARGIN = 24  # pixels of the view around the objects


def scene_picture(scene: LabelledScene, gripper: Gripper, view: int = 0) -> RgbImage:
    """The objects in a view of a scene, with open hands at some of the grasps, (480, 640, 3)."""
    seen = scene.views[view]
    corner, scale = _window(seen)
    box = (*corner, *(corner + np.array(SIZE) / scale))
    picture = Image.fromarray(_shaded(seen)).transform(SIZE, Image.Transform.EXTENT, box)
    draw = ImageDraw.Draw(picture)
    success = scene.grasps["success"].to_numpy(dtype=bool)
    for flags, color in ((~success, FAILED), (success, HELD)):
        for pose in scene.poses[np.flatnonzero(flags)[:MAX_SHOWN]]:
            line = _outline(gripper) @ pose[:3, :3].T + pose[:3, 3]
            local = (line - seen.pose[:3, 3]) @ seen.pose[:3, :3]
            pixels = scale * (seen.intrinsics.pixels(local) + 0.5 - corner)
            draw.line([tuple(point) for point in pixels.tolist()], fill=color, width=3)
    return np.asarray(picture)


def scene_png(scene: LabelledScene, gripper: Gripper) -> bytes:
    """The same for the first view, as a PNG file."""
    buffer = io.BytesIO()
    Image.fromarray(scene_picture(scene, gripper)).save(buffer, "png", compress_level=6)
    return buffer.getvalue()


def _window(view: View) -> tuple[Floats, float]:
    """Upper left corner of the part that is shown, (2,) pixels, and by how much it is enlarged."""
    rows, columns = np.nonzero(view.mask if view.mask.any() else np.ones_like(view.mask))
    ends = np.array([[columns.min(), rows.min()], [columns.max() + 1, rows.max() + 1]], float)
    scale = float((SIZE / (ends[1] - ends[0] + 2 * MARGIN)).min())
    return ends.mean(axis=0) - np.array(SIZE) / scale / 2, scale


def _shaded(view: View) -> RgbImage:
    """Colors by object, darker where the surface is steep towards the camera."""
    colors = np.vstack([TABLE, np.resize(COLORS, (255, 3))])[view.mask]
    down, across = np.gradient(np.nan_to_num(view.depth.astype(np.float64)))
    pixel = view.depth / view.intrinsics.focal
    shade = 1 / np.sqrt(1 + (np.hypot(down, across) / pixel) ** 2)
    lit = colors * (0.35 + 0.65 * np.nan_to_num(shade))[..., None]
    return np.asarray(lit, dtype=np.uint8)


def _outline(gripper: Gripper) -> Floats:
    """Fingers and stem of the open hand as one line, (7, 3), in its frame."""
    base, tip = finger_span(gripper)
    half = gripper.opening / 2
    along = [(-half, tip), (-half, base), (0, base), (0, 2 * base), (0, base), (half, base)]
    return np.array([[x, 0.0, z] for x, z in (*along, (half, tip))])
