"""Sensor noise of depth cameras."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad._util.arrays import Flags, Floats
from egad.detectors.camera import View
from egad.detectors.parameters import ImageNoise, NoiseName

Depth = NDArray[np.float32]
BASELINE = 0.05  # metres between the two imagers of a D435
MIN_DISPARITY = 1.0  # pixels; far beyond everything there is
MATCHED = 7  # pixels; side of the windows that are matched (Keselman et al. 2017)
MAX_INCIDENCE = 80.0  # degrees
SPOT = 1.5  # pixels; how far lost pixels keep together
STEREO = ImageNoise(disparity=0.1, holes=True)
# From the later code of VGN, after Dex-Net 2.0
GAMMA_SHAPE, GAMMA_SIGMA, GAMMA_GRID = 1000.0, 0.005, 4  # metres; pixels
DEX_RATE = 0.5  # as in GIGA: how often the second part is added


def add_noise(noise: NoiseName, view: View, rng: np.random.Generator) -> View:
    """A view as a real camera takes it.

    stereo: `add_sensor_noise` of 0.1 pixels with holes; gamma, dex: `add_gamma_noise`, dex with its
    second part in half of the images; points: none here, it is added to the points of a cloud.
    """
    if noise == "stereo":
        return add_sensor_noise(view, STEREO, rng)
    if noise in ("gamma", "dex"):
        return add_gamma_noise(view, rng, DEX_RATE if noise == "dex" else 1.0)
    return view


def add_gamma_noise(view: View, rng: np.random.Generator, rate: float = 1.0) -> View:
    """A view with the noise of Dex-Net 2.0 (Mahler et al. 2017), as in the later code of VGN.

    All depths are multiplied by one number with a gamma distribution, of mean 1 and standard
    deviation 0.03. Then, with the probability `rate`, normal noise of 5 mm is added, independent
    every 4 pixels and interpolated in between.
    """
    factor = rng.gamma(GAMMA_SHAPE, 1 / GAMMA_SHAPE)
    depth = view.depth * factor
    if rate == 1 or rng.random() < rate:
        height, width = view.depth.shape
        coarse = rng.normal(0, GAMMA_SIGMA, (height // GAMMA_GRID, width // GAMMA_GRID))
        zoom = (height / coarse.shape[0], width / coarse.shape[1])
        depth = depth + ndimage.zoom(coarse, zoom, order=1)
    return replace(view, depth=depth.astype(np.float32))


def add_sensor_noise(view: View, noise: ImageNoise, rng: np.random.Generator) -> View:
    """A view as a stereo camera takes it: disparity noise, then holes, then lost pixels (ours).

    The disparity, baseline * focal length / depth, gets normal noise, so that the depth errs in
    proportion to its square: with 0.1 pixels by 1.7 mm at 0.6 m. Stereo cameras match windows of
    pixels, 7 x 7 in a RealSense R200 (Keselman et al. 2017, "Intel RealSense stereoscopic depth
    cameras"), so the errors of pixels less than 7 apart in both directions are correlated. Holes
    are where the second imager sees nothing (`stereo_shadow`), and where it sees the surface at too
    steep a slant (`grazing`).

    Args:
        view: What an ideal camera sees.
        noise: What goes wrong; each kind may be off.
        rng: Random number generator.
    """
    found = view.depth.copy()
    if noise.disparity > 0:
        found = _with_disparity_noise(view, noise.disparity, rng)
    if noise.holes:
        found[stereo_shadow(view) | grazing(view)] = np.nan
    if noise.missing > 0:
        found[_spots(found.shape, noise.missing, rng)] = np.nan
    return replace(view, depth=found)


def _with_disparity_noise(view: View, sigma: float, rng: np.random.Generator) -> Depth:
    """The depth from disparities whose error has the standard deviation sigma, pixels."""
    scale = BASELINE * view.intrinsics.focal
    white = rng.standard_normal(view.depth.shape)
    # The mean of n * n independent numbers deviates 1 / n times as much as one.
    error = MATCHED * ndimage.uniform_filter(white, MATCHED, mode="wrap")
    disparity = scale / view.depth + sigma * error
    return (scale / np.maximum(disparity, MIN_DISPARITY)).astype(np.float32)


def stereo_shadow(view: View) -> Flags:
    """The pixels that a stereo camera has no depth for: its second imager does not see there.

    That imager is `BASELINE` to the right, and sees a pixel of column u in column u - disparity.
    What is nearer hides what would be further right there, so along a row the columns of all that
    both see ascend. An image wider than this one is assumed: nothing is lost at its sides.
    """
    columns = np.arange(view.depth.shape[1]) - BASELINE * view.intrinsics.focal / view.depth
    columns = np.where(np.isfinite(columns), columns, np.inf)
    nearest = np.minimum.accumulate(columns[:, ::-1], axis=1)[:, ::-1]
    hidden = np.zeros(columns.shape, dtype=bool)
    hidden[:, :-1] = columns[:, :-1] >= nearest[:, 1:]
    return hidden & np.isfinite(view.depth)


def grazing(view: View) -> Flags:
    """The pixels whose surface is too slanted for stereo matching, by 80 degrees or more.

    The angle is that between line of sight and surface normal. The disparity then changes by
    baseline / depth * tan(angle) = 0.5 pixels per pixel at 0.55 m, half of the gradient at which
    matches become ambiguous (Pollard, Mayhew and Frisby 1985, "PMF"), and by several pixels over a
    window that is matched. The normal follows from the differences to the next pixels, in rows
    and in columns to the one of more similar depth: beside an edge, a level surface is level.
    """
    depth, focal = view.depth, view.intrinsics.focal
    along_v, along_u = _slope(depth, 0), _slope(depth, 1)
    x, y = view.intrinsics.slopes()
    # The normal of a depth image is (-f z_u, -f z_v, z + (u - c_u) z_u + (v - c_v) z_v).
    forward = depth + focal * (x * along_u + y[:, None] * along_v)
    normal = focal**2 * (along_u**2 + along_v**2) + forward**2
    ray = 1 + x**2 + (y**2)[:, None]
    least = np.cos(np.radians(MAX_INCIDENCE)) ** 2
    return np.asarray(depth.astype(np.float64) ** 2 < least * normal * ray)


def _slope(depth: Depth, axis: int) -> Floats:
    """The smaller of the differences to the next pixels on either side, metres per pixel."""
    steps = np.diff(depth.astype(np.float64), axis=axis)
    first, last = np.take(steps, [0], axis), np.take(steps, [-1], axis)
    back, ahead = np.concatenate([first, steps], axis), np.concatenate([steps, last], axis)
    return np.where(np.abs(back) < np.abs(ahead), back, ahead)


def _spots(shape: tuple[int, ...], part: float, rng: np.random.Generator) -> Flags:
    """Spots that cover about this part of an image."""
    field = ndimage.gaussian_filter(rng.standard_normal(shape), SPOT, mode="wrap")
    return np.asarray(field < np.quantile(field, part))
