"""Small shaded pictures of voxels, quick enough for maps that are being filled."""

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from egad.report.render import CAMERA, FILL, KEY_LIGHT

SUBSAMPLES = 2
OVERLAP = 1.8  # side of the square that a voxel covers, in voxels: wide enough to leave no gaps
MARGIN = 2  # empty voxels around a solid
AMBIENT = 0.25
HIDDEN = -0.3  # voxels whose normals point further away from the viewer are not painted
Pixels = NDArray[np.uint8]


def voxel_picture(voxels: NDArray[np.bool_], size: int) -> Pixels:
    """Draw a solid seen from in front and above, in the light of `render` (ours).

    The voxels of its surface are painted as squares, the farthest first, each in the brightness
    of its normal.

    Args:
        voxels: (r, r, r), not empty.
        size: Pixels a side.

    Returns:
        Grey and alpha, (size, size, 2).
    """
    solid = np.pad(voxels, MARGIN)
    surface = np.argwhere(solid & ~_inside(solid))
    seen = (surface - surface.mean(axis=0)) @ CAMERA.T.astype(np.float64)
    low, high = seen[:, :2].min(axis=0) - OVERLAP / 2, seen[:, :2].max(axis=0) + OVERLAP / 2
    side = SUBSAMPLES * size
    scale = FILL * side / (high - low).max()
    normals = _normals(solid, surface)
    order = np.argsort(seen[:, 2])
    order = order[normals[order, 2] > HIDDEN]
    corners = (seen[order, :2] - (low + high) / 2 - OVERLAP / 2) * scale + side / 2
    steps = np.arange(int(np.ceil(OVERLAP * scale)))
    across, upwards = (np.clip(np.rint(corners[:, i, None]) + steps, 0, side - 1) for i in (0, 1))
    pixels = (side - 1 - upwards[:, :, None]) * side + across[:, None, :]
    canvas = np.zeros(side * side, np.float32)
    lit = np.clip(normals[order] @ KEY_LIGHT, 0, 1)
    paint = AMBIENT + (1 - AMBIENT) * lit
    canvas[pixels.astype(np.intp).ravel()] = np.repeat(paint, len(steps) ** 2)
    return _average(canvas.reshape(side, side), size)


def _inside(solid: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Voxels whose six neighbours are solid; the margin is empty."""
    inside = np.ones_like(solid)
    for axis in range(3):
        inside &= np.roll(solid, 1, axis) & np.roll(solid, -1, axis)
    return inside


def _normals(solid: NDArray[np.bool_], surface: NDArray[np.int64]) -> NDArray[np.float32]:
    """Outward normals at voxels of the surface in camera coordinates, (n, 3)."""
    density = solid.astype(np.float32)
    for axis in range(3):
        density = 2 * density + np.roll(density, 1, axis) + np.roll(density, -1, axis)
    places = np.ravel_multi_index(tuple(surface.T), solid.shape)
    flat, strides = density.ravel(), np.cumprod([1, *solid.shape[:0:-1]])[::-1]
    normals = np.stack([flat[places - step] - flat[places + step] for step in strides], axis=1)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-6)
    return np.asarray(normals @ CAMERA.T)


def _average(canvas: NDArray[np.float32], size: int) -> Pixels:
    """One pixel for each block of subsamples; only what is painted counts for its grey."""
    split = canvas.reshape(size, SUBSAMPLES, size, SUBSAMPLES).swapaxes(1, 2)
    blocks = split.reshape(size, size, SUBSAMPLES**2)
    painted = np.count_nonzero(blocks, axis=2)
    grey = blocks.sum(axis=2) / np.maximum(painted, 1)
    alpha = painted / SUBSAMPLES**2
    pixels: Pixels = np.rint(255 * np.stack([grey, alpha], axis=2)).astype(np.uint8)
    return pixels


def png(picture: Pixels) -> bytes:
    """A PNG file of grey and alpha."""
    buffer = io.BytesIO()
    Image.fromarray(picture, "LA").save(buffer, "png")
    return buffer.getvalue()
