"""Do training sets differ by more than the luck of single trainings?"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.stats import f_oneway

from egad.trials.training_sets import SetRate


@dataclass(frozen=True)
class Luck:
    """How success differs within training sets and between them.

    Attributes:
        spread: Standard deviation of the success of a network of the same set, pooled over sets.
        sets: How many sets have several networks; the others say nothing of it.
        networks: How many networks these have.
        f: The variance between sets over that within them, as if all sets were equal.
        p: How often it is as large as that if all sets are equally good to learn from.
    """

    spread: float
    sets: int
    networks: int
    f: float
    p: float


def luck(rates: Mapping[str, SetRate]) -> Luck | None:
    """A one-way analysis of variance of the success of networks, by training set.

    It takes each training for one draw, and knows nothing of attempts and objects: p is about other
    trainings, on the same drops of the same objects. Few networks a set find large effects only.

    Args:
        rates: Success by training set.

    Returns:
        None if fewer than two sets have several networks, or those of a set never differ.
    """
    each = [[rate.value for rate in found.each.values()] for found in rates.values()]
    several = [values for values in each if len(values) > 1]
    if len(several) < 2 or all(len(set(values)) == 1 for values in several):
        return None
    networks = sum(map(len, several))
    spread = np.sqrt(_within(several) / (networks - len(several)))
    found = f_oneway(*several)
    return Luck(float(spread), len(several), networks, float(found.statistic), float(found.pvalue))


def _within(groups: list[list[float]]) -> float:
    """The sum of squares about the mean of each group."""
    return float(sum(np.square(np.subtract(values, np.mean(values))).sum() for values in groups))
