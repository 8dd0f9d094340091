"""How well a rating tells grasps that hold from grasps that do not."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from egad.trials.statistics import Interval, bootstrap

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Area:
    """Area under the ROC curve: how often a success was rated higher than a failure.

    Attributes:
        value: 1 if the rating tells all, 0.5 if it tells nothing; ties count half. NaN if there
            are no successes, or no failures.
        interval: Of 95 %, for other objects of the same kind; NaN if nothing is known.
        within: The same of pairs of grasps of one object only.
    """

    value: float
    interval: Interval
    within: float = np.nan


def area(rating: Floats, success: NDArray[np.bool_], objects: NDArray[np.str_]) -> Area:
    """Area under the ROC curve of the grasps of several objects.

    Grasps of an object resemble each other, so it is the objects that are drawn (`bootstrap`); one
    drawn twice counts twice.

    Args:
        rating: (n,) of each grasp.
        success: (n,) whether it held.
        objects: (n,) name of its object.
    """
    names, owner = np.unique(objects, return_inverse=True)
    count = len(names)
    member = (owner[:, None] == np.arange(count)).astype(np.float64)
    good, bad = member[success], member[~success]
    apart = rating[success][:, None] - rating[~success][None]
    won = good.T @ ((np.sign(apart) + 1) / 2) @ bad
    counts = good.sum(axis=0), bad.sum(axis=0)

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
    same = float(np.trace(won) / pairs) if pairs else np.nan
    value = float(areas(np.arange(count)[None])[0]) if count else np.nan
    return Area(value, bootstrap(areas, count), same)
