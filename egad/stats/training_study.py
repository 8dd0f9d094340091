"""Paired comparison of networks trained on different object sets, with the variance of seeds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import f_oneway

from egad.errors import UserError
from egad.stats.paired import Comparison, compare
from egad.stats.rates import Mean, Rate, mean_rate, rate

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SetRate:
    """How often the networks of a training set succeeded.

    Attributes:
        pooled: All of them; its interval is for other objects of the same kind, and these networks.
        each: Each of them, by its seed.
    """

    pooled: Mean
    each: dict[int, Rate]


@dataclass(frozen=True)
class TestAttempts:
    """All that was tried in a test.

    Attributes:
        rows: Its attempts, columns of `tables.training.COMPARED`.
        sets: Success by training set, in the order of the table.
        references: Success of the other detectors.
    """

    rows: pd.DataFrame
    sets: dict[str, SetRate]
    references: dict[str, Mean]


@dataclass(frozen=True)
class SetPair:
    """Two training sets; the networks of the first have the higher rate.

    Attributes:
        first: Name of the set.
        second: Name of the other one.
        result: Networks against networks, see `set_pairs`. Where one set has a single network, its
            attempts count once for each network of the other, so look at the objects only.
        each: The same difference of network 0 and network 0 and so on.
        p_holm: The p-value over the objects, for as many pairs as there are.
    """

    first: str
    second: str
    result: Comparison
    each: list[float]
    p_holm: float


def by_test(table: pd.DataFrame) -> dict[str, TestAttempts]:
    """Success in each test, in the order of the table.

    Args:
        table: Columns of `tables.training.COMPARED`.
    """
    return {
        str(name): TestAttempts(
            rows,
            {key: set_rate(own) for key, own in by_set(rows).items()},
            {key: mean_rate(own) for key, own in references(rows).items()},
        )
        for name, rows in table.groupby("test", sort=False)
    }


def by_set(table: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """The attempts of the networks of each training set, in the order of the table.

    Args:
        table: Columns of `tables.training.COMPARED`, of one test.
    """
    trained = table[table["training_set"] != ""]
    return {str(name): rows for name, rows in trained.groupby("training_set", sort=False)}


def references(table: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """The attempts of the other detectors in the same table."""
    others = table[table["training_set"] == ""]
    return {str(name): rows for name, rows in others.groupby("detector", sort=False)}


def set_rate(rows: pd.DataFrame) -> SetRate:
    """The success of the networks of a training set.

    Objects are drawn for the interval, each with the attempts of all networks: those on one object
    resemble each other, whichever network makes them.
    """
    seeds = sorted(map(int, rows["seed"].unique()))
    return SetRate(mean_rate(rows), {seed: rate(rows[rows["seed"] == seed]) for seed in seeds})


def check_starts(rows: pd.DataFrame) -> None:
    """Refuse attempts that should start from the same drop and do not.

    An attempt at an object that cannot be simulated has no initial pose.

    Args:
        rows: Columns label, attempt, start and detector, of one test.

    Raises:
        UserError: A detector met an object in another pose than those before it.
    """
    attempted = rows[rows["initial_pose"] != ""]
    usual = attempted.groupby(["label", "attempt"])["initial_pose"].transform("first")
    odd = attempted[attempted["initial_pose"] != usual]
    if len(odd):
        detector, label, attempt = odd.iloc[0][["detector", "label", "attempt"]]
        raise UserError(
            f"{detector} started attempt {attempt} at {label} with a different drop than earlier "
            "detectors; with `trials.reset: redrop` all drops must be equal: repeat the trials"
        )


def set_pairs(sets: Mapping[str, pd.DataFrame]) -> list[SetPair]:
    """Every two training sets compared, network 0 with network 0 and so on.

    The gain of an object is summed over the networks before objects are looked at (`compare`). If
    one set has a single network, as that of given weights has, each network of the other set is
    compared with that one.

    Args:
        sets: From `by_set`.

    Raises:
        UserError: They did not try the same objects, or have different numbers of networks, both
            more than one.
    """
    found = [_pair(sets, *names) for names in combinations(sets, 2)]
    corrected = holm(np.array([pair.p_holm for pair in found]))
    return [replace(pair, p_holm=float(p)) for pair, p in zip(found, corrected, strict=True)]


def _pair(sets: Mapping[str, pd.DataFrame], first: str, second: str) -> SetPair:
    """Two sets compared, as if there were no others."""
    networks = _opposite(sets, first, second)
    one, other = (_numbered(parts) for parts in zip(*networks, strict=True))
    result = compare(one, other)
    if result.difference < 0:
        return _pair(sets, second, first)
    each = [compare(*parts).difference for parts in networks]
    return SetPair(first, second, result, each, result.p_objects)


def _opposite(
    sets: Mapping[str, pd.DataFrame], first: str, second: str
) -> list[tuple[pd.DataFrame, pd.DataFrame]]:
    """Attempts of each network of a set and of that of the other set it is compared with."""
    one, other = ([rows for _, rows in sets[name].groupby("seed")] for name in (first, second))
    most = max(len(one), len(other))
    if {len(one), len(other)} - {1, most}:
        raise UserError(
            f"{len(one)} networks of {first} and {len(other)} of {second} cannot be "
            "paired: both sets need equal numbers, or one of them a single network"
        )
    return list(zip(one * (most // len(one)), other * (most // len(other)), strict=True))


def _numbered(parts: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Attempts of several networks in one table, under numbers of their own."""
    numbered = [
        rows.assign(attempt=rows["attempt"] * len(parts) + number)
        for number, rows in enumerate(parts)
    ]
    return pd.concat(numbered)


def holm(p_values: Floats) -> Floats:
    """P-values of several tests, so that one of all is below 0.05 by chance in one of 20 cases.

    The smallest of n is multiplied by n, the next by n - 1 and so on, and none is less than one
    before it (Holm 1979).

    Args:
        p_values: (n,)

    Returns:
        (n,) at most 1.
    """
    order = np.argsort(p_values)
    steps = p_values[order] * np.arange(len(p_values), 0, -1)
    found = np.empty(len(p_values))
    found[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return found


@dataclass(frozen=True)
class SeedVariance:
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


def seed_variance(rates: Mapping[str, SetRate]) -> SeedVariance | None:
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
    return SeedVariance(
        float(spread), len(several), networks, float(found.statistic), float(found.pvalue)
    )


def _within(groups: list[list[float]]) -> float:
    """The sum of squares about the mean of each group."""
    return float(sum(np.square(np.subtract(values, np.mean(values))).sum() for values in groups))
