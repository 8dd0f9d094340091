"""Networks that learnt from different objects, tried on the same drops: is one set better?"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.trials.comparison import Comparison, compare
from egad.trials.statistics import Mean, Rate, mean_rate, rate

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
class SetPair:
    """Two training sets; the first has the higher rate.

    Attributes:
        first: Name of the set.
        second: Name of the other one.
        result: Networks against networks, see `set_pairs`. Where one set has a single network, its
            attempts count once for each network of the other, so look at the objects only.
        p_holm: The p-value over the objects, for as many pairs as there are.
    """

    first: str
    second: str
    result: Comparison
    p_holm: float


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


def set_pairs(sets: Mapping[str, pd.DataFrame]) -> list[SetPair]:
    """Every two training sets compared, network 0 with network 0 and so on.

    The gain of an object is summed over the networks before objects are looked at (`compare`). If
    one set has a single network, as that of given weights has, each network of the other set is
    compared with that one.

    Args:
        sets: From `by_set`.

    Raises:
        UserError: They did not try the same objects.
    """
    most = max((rows["seed"].nunique() for rows in sets.values()), default=0)
    tables = {name: _numbered(rows, most) for name, rows in sets.items()}
    found = [_ordered(tables, *names) for names in combinations(tables, 2)]
    corrected = holm(np.array([result.p_objects for _, _, result in found]))
    return [SetPair(*pair, float(p)) for pair, p in zip(found, corrected, strict=True)]


def _ordered(
    tables: Mapping[str, pd.DataFrame], first: str, second: str
) -> tuple[str, str, Comparison]:
    result = compare(tables[first], tables[second])
    if result.difference >= 0:
        return first, second, result
    return second, first, compare(tables[second], tables[first])


def _numbered(rows: pd.DataFrame, networks: int) -> pd.DataFrame:
    """Attempts of several networks, or those of one again and again, under numbers of their own."""
    seeds = sorted(rows["seed"].unique())
    shift = int(rows["attempt"].max()) + 1
    parts = [rows[rows["seed"] == seeds[number % len(seeds)]] for number in range(networks)]
    numbers = [part["attempt"] + number * shift for number, part in enumerate(parts)]
    columns = ["label", "id", "success", "start"]
    renamed = zip(parts, numbers, strict=True)
    table: pd.DataFrame = pd.concat([part[columns].assign(attempt=each) for part, each in renamed])
    return table


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
