"""Removal of holes and noise from depth images, using the images alone (ours)."""

from dataclasses import replace

import numpy as np
import pandas as pd
import skimage  # its parts are loaded when they are used
from scipy import ndimage

from egad._util.arrays import Flags, Floats
from egad.detectors.camera import Depth, View, Window, table_depth
from egad.detectors.heightmap import window_of
from egad.grasps import TABLE_CLEARANCE

MIN_NOISE = 1e-4  # metres; stored images are rounded to that
QUARTILE = 0.6745  # of the normal distribution
WINDOW = 9  # pixels; side of the window of the filter
SPREAD = 2.5  # pixels; standard deviation of its weights by distance
TOLERANCE = 3.0  # standard deviations of the noise; that of its weights by depth
SMOOTHING = 5  # pixels
STANDING = 2.5  # standard deviations over the table that count beside what surely stands there
SURELY_STANDING = 5.0
MARGIN = 12  # pixels of table around what stands; enough for the window, and to estimate the noise


def restore(view: View) -> View:
    """A view of a table for detectors, without holes and noise as far as possible (ours).

    Holes are filled (`fill_missing`). If the image has noise (`noise_of`), what stands on the
    table is denoised by a bilateral filter (Tomasi and Manduchi 1998): an average over depths that
    differ by little more than the noise, so that edges stay. The rest is set to the height 0 of
    the table. What stands is at least 3 mm and 2.5 standard deviations high, and higher than 5
    standard deviations somewhere, so that no bump of the noise is taken for an obstacle.

    Args:
        view: A depth image; the table is at height 0, and some of it is seen.

    Returns:
        Depth everywhere, unless it is missing everywhere; a view without holes and noise is
        unchanged.
    """
    if not np.isfinite(view.depth).any():
        return view
    whole = replace(view, depth=fill_missing(view.depth))
    heights = whole.heights()
    noise = noise_of(heights)
    if noise <= MIN_NOISE:
        return whole
    window = window_of(_standing(ndimage.uniform_filter(heights, SMOOTHING)), MARGIN)
    return _denoised(whole, window, noise)


def _denoised(view: View, window: Window, noise: float) -> View:
    """What stands in a window of a view, filtered, and nothing but table elsewhere."""
    depth = table_depth(view.intrinsics, view.pose)
    found = replace(view, depth=depth.copy())
    part = view.depth[window].astype(np.float64)
    if part.size > 0:
        found.depth[window] = skimage.restoration.denoise_bilateral(
            part, WINDOW, TOLERANCE * noise, SPREAD
        )
        table = ~_standing(found.heights()[window])
        found.depth[window][table] = depth[window][table]
    return found


def _standing(heights: Floats) -> Flags:
    """Which pixels see what stands on the table; heights in metres, (height, width)."""
    noise = noise_of(heights)
    low = max(STANDING * noise, TABLE_CLEARANCE)
    high = max(SURELY_STANDING * noise, TABLE_CLEARANCE)
    return np.asarray(skimage.filters.apply_hysteresis_threshold(heights, low, high))


def noise_of(heights: Floats) -> float:
    """Standard deviation of the noise of heights over a table, metres.

    Nothing is lower than the table, so whatever seems lower is noise. The median of these depths
    below it gives the standard deviation of normal noise; 0 if nothing is below.
    """
    below = heights[heights < 0]
    return float(np.median(-below)) / QUARTILE if below.size > 0 else 0.0


def fill_missing(depth: Depth) -> Depth:
    """Fill each missing pixel, NaN, with the larger of the nearest depths to its left and right.

    The imagers of a stereo camera are side by side: what only one of them sees is behind something
    that is nearer. A row without any depth is like the next row that has some; one must have some.
    """
    gaps = ~np.isfinite(depth)
    if not gaps.any():
        return depth
    rows = pd.DataFrame(np.where(gaps, np.nan, depth))
    behind = pd.DataFrame(np.fmax(rows.ffill(axis=1), rows.bfill(axis=1)))
    whole: Depth = behind.bfill().ffill().to_numpy(depth.dtype)
    return whole
