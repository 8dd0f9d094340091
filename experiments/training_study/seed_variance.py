"""The tables on power for docs/studies/training-plan.md: `python seed_variance.py`.

How many networks per training set it takes to show a difference of 5 points between two sets in
80 % of the cases, and how large a difference has to be for 2 and for 8 networks.
"""

import bisect
from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.stats import ttest_ind

from egad.random import generator

OBJECTS = {"egad": 49, "ycb": 29}  # of the evaluation sets
ATTEMPTS, REPEATS = 10, 2000
SPREADS = (0.01, 0.02, 0.03, 0.04)
GAIN, POWER = 0.05, 0.8
TESTS = 8  # pre-registered; Holm's correction compares the smallest p with 0.05 / TESTS
LEVELS = {"p < 0.05": 0.05, "Holm": 0.05 / TESTS}
FEW, MANY = 2, 8  # networks per set


def main() -> None:
    """Print both tables."""
    columns = [(objects, level) for objects in OBJECTS.values() for level in LEVELS.values()]
    heads = [f"{name}, {rule}" for name in OBJECTS for rule in LEVELS]
    table([*heads, *(f"{name}, equal sets" for name in OBJECTS)])
    for spread in SPREADS:
        equal = [100 * share(spread, objects, 5, 0, 0.05) for objects in OBJECTS.values()]
        found = [networks_needed(spread, *column) for column in columns]
        print(row(spread, [*found, *(f"{errors:.1f} %" for errors in equal)]))
    table([f"{networks}: {head}" for networks in (FEW, MANY) for head in heads])
    for spread in SPREADS:
        gains = [smallest_gain(spread, n, *column) for n in (FEW, MANY) for column in columns]
        print(row(spread, gains))


def table(heads: list[str]) -> None:
    """Print the first lines of a table."""
    print(f"\n| standard deviation | {' | '.join(heads)} |\n" + "| --- " * (len(heads) + 1) + "|")


def row(spread: float, cells: Iterable[object]) -> str:
    """A line of a table."""
    return f"| {100 * spread:.0f} | {' | '.join(map(str, cells))} |"


def networks_needed(spread: float, objects: int, level: float) -> int:
    """The smallest number of networks per set that mostly shows a gain of 5 points."""
    return first(range(3, 60), lambda count: share(spread, objects, count, GAIN, level))


def smallest_gain(spread: float, networks: int, objects: int, level: float) -> int:
    """The smallest gain that this number of networks mostly shows, points."""
    return first(range(1, 61), lambda gain: share(spread, objects, networks, gain / 100, level))


def first(numbers: range, power: Callable[[int], float]) -> int:
    """The first of ascending numbers with enough power; bisected, as power grows with them."""
    found: int = numbers.start + bisect.bisect_left(numbers, POWER, key=power)
    return found


def share(spread: float, objects: int, networks: int, gain: float, level: float) -> float:
    """How often Welch's test tells two sets apart.

    Args:
        spread: Standard deviation of the success of the networks of a set, if each made
            infinitely many attempts.
        objects: How many are tried.
        networks: Networks of each set.
        gain: Mean success of the second set minus that of the first.
        level: The p-value must be lower.
    """
    random = generator(0, "power", objects, networks, round(1000 * spread), round(1000 * gain))
    one, other = (rates(random, spread, objects, networks, mean) for mean in (0, gain))
    return float(np.mean(ttest_ind(one, other, axis=1, equal_var=False).pvalue < level))


def rates(
    random: np.random.Generator, spread: float, objects: int, networks: int, gain: float
) -> NDArray[np.float64]:
    """Success of the networks of a set, (repeats, networks).

    Each object is grasped with its own probability, from Beta(2, 2). Those of a network are
    shifted, most where success is neither rare nor certain. Attempts are independent.
    """
    easy = generator(0, "objects", objects).beta(2, 2, objects)
    movable = easy * (1 - easy) / np.mean(easy * (1 - easy))
    shifts = random.normal(gain, spread, (REPEATS, networks, 1))
    won = random.binomial(ATTEMPTS, np.clip(easy + shifts * movable, 0, 1))
    found: NDArray[np.float64] = won.mean(axis=2) / ATTEMPTS
    return found


if __name__ == "__main__":
    main()
