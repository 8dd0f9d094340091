"""Two detectors that tried the same objects: is one better, or was it luck?"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import binomtest

from egad.errors import UserError
from egad.trials.statistics import Interval, bootstrap

Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Comparison:
    """The first of two detectors against the second, over the attempts that both made.

    Attributes:
        objects: Objects that both tried.
        attempts: Attempts that both made.
        difference: Success rate of the first minus that of the second.
        interval: Of the difference, 95 %: had other objects of the same kind been taken.
        p_objects: Sign-flip test over the objects; see `sign_flip`.
        only_first: Attempts that only the first succeeded in.
        only_second: Attempts that only the second succeeded in.
        p_attempts: Exact McNemar test over the attempts; NaN unless both faced the same drops.
    """

    objects: int
    attempts: int
    difference: float
    interval: Interval
    p_objects: float
    only_first: int
    only_second: int
    p_attempts: float


def compare(first: pd.DataFrame, second: pd.DataFrame) -> Comparison:
    """Compare two detectors on the same attempts.

    The test to go by is that over the objects: attempts on one object resemble each other, and a
    detector that is better at one shape is so in all 20 attempts at it. McNemar's test takes them
    for independent, and so answers for these very objects only.

    Args:
        first: Columns label, attempt, success, and seed, which is empty where drops cannot be
            repeated.
        second: The same of the other detector.

    Raises:
        UserError: They have no attempt in common.
    """
    pairs = first.merge(second, on=["label", "attempt"], suffixes=("_1", "_2"))
    if pairs.empty:
        raise UserError("the two tables have no attempt in common: same labels and numbers")
    one, other = (pairs[f"success_{i}"].to_numpy(dtype=np.int64) for i in (1, 2))
    labels, index = np.unique(pairs["label"], return_inverse=True)
    gains, counts = (np.bincount(index, values).astype(np.int64) for values in (one - other, None))
    only_first, only_second = int((one > other).sum()), int((other > one).sum())
    seeds = pairs["seed_1"]
    same = bool(((seeds != "") & (seeds == pairs["seed_2"])).all())
    return Comparison(
        objects=len(labels),
        attempts=len(pairs),
        difference=float((one - other).mean()),
        interval=bootstrap(lambda drawn: gains[drawn].sum(1) / counts[drawn].sum(1), len(labels)),
        p_objects=sign_flip(gains),
        only_first=only_first,
        only_second=only_second,
        p_attempts=mcnemar(only_first, only_second) if same else float("nan"),
    )


def sign_flip(gains: Integers) -> float:
    """Exact two-sided permutation test that differences have no sign they prefer.

    If neither detector is better, each object could as well have favoured the other one by as
    much. Of all 2^n ways to choose the signs this is the part whose sum is at least as far from 0;
    they are counted by adding one object after the other to the distribution of the sum.

    Args:
        gains: (n,) successes of one detector minus those of the other, by object.

    Returns:
        The p-value; 1 if there are no differences.
    """
    sizes = np.abs(gains)
    reach = int(sizes.sum())
    chance = np.zeros(2 * reach + 1)
    chance[reach] = 1.0  # index = sum + reach
    for size in sizes[sizes > 0]:
        chance = (np.roll(chance, size) + np.roll(chance, -size)) / 2  # what wraps around is 0
    sums = np.arange(-reach, reach + 1)
    return float(min(chance[np.abs(sums) >= abs(gains.sum())].sum(), 1.0))


def mcnemar(only_first: int, only_second: int) -> float:
    """Exact two-sided McNemar test: the p-value that attempts which differ favour neither.

    Args:
        only_first: Attempts that only one detector succeeded in.
        only_second: Attempts that only the other one did.
    """
    differing = only_first + only_second
    return float(binomtest(only_first, differing).pvalue) if differing else 1.0
