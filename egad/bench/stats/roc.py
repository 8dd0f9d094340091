"""How well a predicted quality separates successful from failed grasps: ROC area, calibration."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd
import scipy  # scipy.stats is loaded when it is used
from numpy.typing import NDArray

from egad._util.arrays import Flags, Floats
from egad.bench.stats.rates import Interval, Rate, bootstrap

Names = NDArray[np.str_]
Areas = Callable[[NDArray[np.int64]], Floats]

# A bootstrap knows only the objects that it has seen. If fewer objects than this have failures, or
# successes, its intervals are too narrow, especially if one object has all of them.
MIN_OBJECTS = 5
BINS = 10
_SIDES: tuple[Literal["left"], Literal["right"]] = ("left", "right")


@dataclass(frozen=True)
class Area:
    """Area under the ROC curve of grasps of objects; `within`: of pairs of the same object only.

    The interval, of 95 %, is for other objects of the same kind; NaN if fewer than `MIN_OBJECTS`
    objects have a success, or a failure.
    """

    value: float
    interval: Interval
    within: float = np.nan


def roc_area(rating: Floats, success: Flags) -> float:
    """How often a success is rated above a failure; ties count half (Mann and Whitney)."""
    good, bad = rating[success], rating[~success]
    if len(good) == 0 or len(bad) == 0:
        return np.nan
    higher = scipy.stats.mannwhitneyu(good, bad, method="asymptotic").statistic
    return float(higher / (len(good) * len(bad)))


def area(rating: Floats, success: Flags, objects: Names) -> Area:
    """Area under the ROC curve of ratings, (n,); the interval resamples objects (`bootstrap`)."""
    areas, within = _areas(rating, success, objects)
    return Area(roc_area(rating, success), _interval(areas, success, objects), within)


def gain(rating: Floats, other: Floats, success: Flags, objects: Names) -> Area:
    """How much larger the area of one rating, (n,), is than of another, by the same draws."""
    first, within = _areas(rating, success, objects)
    second, others = _areas(other, success, objects)
    interval = _interval(lambda drawn: first(drawn) - second(drawn), success, objects)
    value = roc_area(rating, success) - roc_area(other, success)
    return Area(value, interval, within - others)


def _interval(areas: Areas, success: Flags, objects: Names) -> Interval:
    """The interval of an area over draws of objects, if there are enough of them."""
    fewest = min(len(np.unique(objects[each])) for each in (success, ~success))
    return bootstrap(areas, len(np.unique(objects))) if fewest >= MIN_OBJECTS else (np.nan, np.nan)


def _areas(rating: Floats, success: Flags, objects: Names) -> tuple[Areas, float]:
    """A function from draws of objects to areas; and the area of pairs of the same object."""
    names, owner = np.unique(objects, return_inverse=True)
    count = len(names)
    counts = [
        np.bincount(owner[each], minlength=count).astype(float) for each in (success, ~success)
    ]
    won = np.empty((count, count))  # pairs of successes of one and failures of another object
    for number in range(count):
        failed = np.sort(rating[~success & (owner == number)])
        below, upto = (np.searchsorted(failed, rating[success], side) for side in _SIDES)
        won[:, number] = np.bincount(owner[success], (below + upto) / 2, count)

    def areas(drawn: NDArray[np.int64]) -> Floats:
        cells = drawn + count * np.arange(len(drawn))[:, None]
        times = np.bincount(cells.ravel(), minlength=count * len(drawn))
        weight = times.reshape(len(drawn), count).astype(np.float64)
        pairs = (weight @ counts[0]) * (weight @ counts[1])
        better = np.einsum("di,di->d", weight @ won, weight)
        found: Floats = np.full(len(drawn), np.nan)
        np.divide(better, pairs, out=found, where=pairs > 0)
        return found

    pairs = float(counts[0] @ counts[1])
    return areas, float(np.trace(won) / pairs) if pairs else np.nan


@dataclass(frozen=True)
class Bin:
    """Mean quality and success rate of attempts of similar quality."""

    quality: float
    rate: Rate


def reliability(trials: pd.DataFrame) -> list[Bin]:
    """Success rates by quality, ascending, in at most ten bins; equal qualities together."""
    quality, success = _known(trials)
    if len(quality) == 0:
        return []
    edges = np.unique(quality)[1:]
    if len(edges) >= BINS:
        edges = np.unique(np.quantile(quality, np.linspace(0, 1, BINS + 1)[1:-1]))
    number = np.searchsorted(edges, quality, side="right")
    return [
        Bin(float(quality[chosen].mean()), Rate(int(success[chosen].sum()), int(chosen.sum())))
        for chosen in (number == each for each in np.unique(number))
    ]


def discrimination(trials: pd.DataFrame) -> float:
    """Area under the ROC curve of the quality, where the detector gave one; see `roc_area`."""
    return roc_area(*_known(trials))


def _known(trials: pd.DataFrame) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Quality and success of the attempts with a quality."""
    quality = trials["quality"].to_numpy(dtype=np.float64)
    known = np.isfinite(quality)
    return quality[known], trials["success"].to_numpy(dtype=bool)[known]
