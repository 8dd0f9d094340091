"""Sensor noise of real depth cameras (ours), and filling of missing pixels."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad.perception.camera import View
from egad.perception.parameters import ImageNoise

Depth = NDArray[np.float32]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
BASELINE = 0.05  # metres between the two imagers of a D435
LEAST_DISPARITY = 1.0  # pixels; far beyond everything there is
SPOT = 1.5  # pixels; how far lost pixels keep together


def fill_missing(depth: Depth) -> Depth:
    """A depth image whose missing pixels have the depth of the nearest one that has any.

    Args:
        depth: Metres; not a number where it is missing, but not everywhere.
    """
    gaps = ~np.isfinite(depth)
    if not gaps.any():
        return depth
    nearest = ndimage.distance_transform_edt(gaps, return_distances=False, return_indices=True)
    whole: Depth = depth[tuple(nearest)]
    return whole


def add_sensor_noise(view: View, noise: ImageNoise, rng: np.random.Generator) -> View:
    """A view as a real camera would have it: shadows, then disparity noise, then lost pixels.

    Args:
        view: What an ideal camera sees.
        noise: What goes wrong; each kind may be off.
        rng: Source of chance.
    """
    clear = noise.disparity == 0
    found = view.depth.copy() if clear else add_disparity_noise(view, noise.disparity, rng).depth
    if noise.shadows:
        found[stereo_shadow(view)] = np.nan
    if noise.missing > 0:
        found[_spots(found.shape, noise.missing, rng)] = np.nan
    return View(found, view.intrinsics, view.pose)


def add_disparity_noise(view: View, sigma: float, rng: np.random.Generator) -> View:
    """The view of a stereo camera that matches its two images with some error (ours).

    The disparity, baseline * focal length / depth, gets normal noise, so that the depth errs in
    proportion to its square: with 0.1 pixels by 1.7 mm at 0.6 m. Each pixel errs by itself, and
    none is lost.

    Args:
        view: What an ideal camera sees.
        sigma: Standard deviation of the disparity, pixels.
        rng: Source of chance.
    """
    scale = BASELINE * view.intrinsics.focal
    disparity = scale / view.depth + sigma * rng.standard_normal(view.depth.shape)
    depth = (scale / np.maximum(disparity, LEAST_DISPARITY)).astype(np.float32)
    return View(depth, view.intrinsics, view.pose)


def stereo_shadow(view: View) -> Flags:
    """The pixels that a stereo camera has no depth for: its second imager does not see there.

    That imager is `BASELINE` to the right, and sees a pixel of column u in column u - disparity.
    What is nearer hides what would be further right there, so along a row the columns of all that
    both see ascend. An image wider than this one is assumed: nothing is lost at its sides.

    Args:
        view: What an ideal camera sees.
    """
    columns = np.arange(view.depth.shape[1]) - BASELINE * view.intrinsics.focal / view.depth
    columns = np.where(np.isfinite(columns), columns, np.inf)
    nearest = np.minimum.accumulate(columns[:, ::-1], axis=1)[:, ::-1]
    hidden = np.zeros(columns.shape, dtype=bool)
    hidden[:, :-1] = columns[:, :-1] >= nearest[:, 1:]
    return hidden & np.isfinite(view.depth)


def _spots(shape: tuple[int, ...], part: float, rng: np.random.Generator) -> Flags:
    """Spots that take about this part of an image."""
    field = ndimage.gaussian_filter(rng.standard_normal(shape), SPOT, mode="wrap")
    return np.asarray(field < np.quantile(field, part))
