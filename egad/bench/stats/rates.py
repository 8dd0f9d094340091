"""Success rates with confidence intervals: overall, per cell of the grid, and as trends."""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
import scipy  # scipy.stats is loaded when it is used
from numpy.typing import NDArray

from egad._util.arrays import Floats, Ints
from egad._util.display import facts_html
from egad.evalset import cell_of_label, in_grid
from egad.random import generator

Interval = tuple[float, float]
DRAWS = 10_000
# With fewer, intervals of rank correlations cover more than 3/4 of all values, from -1 to 1, and
# without any correlation, 2 to 9 % of the samples have one beyond 0.8 (simulated, 4 to 8 objects).
MIN_CORRELATED = 10


def wilson(successes: int, attempts: int, confidence: float = 0.95) -> Interval:
    """Wilson's score interval of a success probability (Wilson 1927); 0 and 1 without attempts."""
    if attempts == 0:
        return 0.0, 1.0
    found = scipy.stats.binomtest(successes, attempts).proportion_ci(confidence, method="wilson")
    return float(found.low), float(found.high)


def bootstrap(statistic: Callable[[NDArray[np.int64]], Floats], count: int) -> Interval:
    """The 95 % interval of a statistic of objects, for other objects of their kind.

    Objects are drawn with replacement, 10,000 times, with a fixed seed. The percentiles of the
    results are corrected for few objects: widened as Student's t is relative to the normal
    distribution, and by sqrt(n / (n - 1)), because the spread of n objects about their own mean is
    too small (Hesterberg 2015, "expanded percentiles").

    Args:
        statistic: From (draws, n) indices of the objects drawn to (draws,) values; NaN where a
            draw has none.
        count: Number of objects, n.

    Returns:
        Lower and upper end; NaN if there are fewer than two objects, or no values.
    """
    if count < 2:
        return np.nan, np.nan
    values = statistic(generator(0, "bootstrap").integers(count, size=(DRAWS, count)))
    if np.isnan(values).all():
        return np.nan, np.nan
    far = expanded_quantile(count)
    ends: Floats = np.nanquantile(values, scipy.stats.norm.cdf(np.array([-far, far])))
    return float(ends[0]), float(ends[1])


def expanded_quantile(count: int) -> float:
    """The two-sided normal quantile of 95 %, further out for few objects; see `bootstrap`."""
    student = scipy.stats.t.ppf(0.975, count - 1)
    return float(np.sqrt(count / (count - 1)) * student)


@dataclass(frozen=True, repr=False)
class Rate:
    """How often something worked."""

    successes: int
    attempts: int

    @property
    def value(self) -> float:
        """Successes / attempts; NaN if there were no attempts."""
        return self.successes / self.attempts if self.attempts else float("nan")

    @property
    def interval(self) -> Interval:
        """Lower and upper end of the Wilson interval of 95 %."""
        return wilson(self.successes, self.attempts)

    def __repr__(self) -> str:
        """The rate and its interval in percent, with the counts."""
        if not self.attempts:
            return "no attempts"
        value, low, high = (100 * each for each in (self.value, *self.interval))
        between = "no interval" if np.isnan(low) else f"95 % interval {low:.1f} to {high:.1f} %"
        return f"{value:.1f} % ({between}), {self.successes} of {self.attempts}"

    def _repr_html_(self) -> str:
        """The same, for notebooks."""
        return facts_html(repr(self), {})


@dataclass(frozen=True, repr=False)
class Mean(Rate):
    """The rate over several objects, each of them tried several times."""

    ci_low: float
    ci_high: float

    @property
    def interval(self) -> Interval:
        """The 95 % interval for other objects of the same kind; see `mean_rate`."""
        return self.ci_low, self.ci_high


@dataclass(frozen=True)
class TrialGrid:
    """Success rates of cells, rows (0 = easiest) and columns (0 = simplest) of the evaluation set.

    Rates of rows and columns are over all attempts there: means over objects tried equally often.
    """

    cells: dict[tuple[int, int], Rate]
    rows: list[Mean]
    columns: list[Mean]
    overall: Mean


def rate(trials: pd.DataFrame) -> Rate:
    """The success rate over all rows of a table of attempts."""
    return Rate(int(trials["success"].sum()), len(trials))


def engine_names(table: pd.DataFrame) -> str:
    """The physics engines of attempts; empty for a real robot."""
    return " and ".join(sorted(set(table["engine"].dropna()) - {""}))


def simulated_in(table: pd.DataFrame) -> str:
    """Engine and unusual settings of `tables.evaluation.RESULTS`; empty for a real robot."""
    usual = {"errors": "none", "contact": "collided"}
    return ", ".join((engine_names(table), *unusual(table, usual)))


def unusual(table: pd.DataFrame, usual: Mapping[str, str]) -> list[str]:
    """Values of columns, such as `errors: typical`, that are neither usual nor empty."""
    others = {
        name: " and ".join(sorted(set(table[name].dropna()) - {"", value}))
        for name, value in usual.items()
        if name in table
    }
    return [f"{name}: {values}" for name, values in others.items() if values]


def by_object(trials: pd.DataFrame) -> pd.DataFrame:
    """Successes and attempts of each object, by its label, in the order of the labels."""
    labels, index = np.unique(trials["label"].to_numpy(dtype=str), return_inverse=True)
    success = trials["success"].to_numpy(dtype=np.float64)
    counts = np.bincount(index, success), np.bincount(index)
    columns = zip(("successes", "attempts"), counts, strict=True)
    return pd.DataFrame({name: values.astype(np.int64) for name, values in columns}, index=labels)


def mean_rate(trials: pd.DataFrame) -> Mean:
    """Success rate over objects, its 95 % interval by `bootstrap`, at least Wilson's."""
    objects = by_object(trials)
    return mean_of(objects["successes"].to_numpy(), objects["attempts"].to_numpy())


def mean_of(successes: Ints, attempts: Ints) -> Mean:
    """Success rate over groups of attempts, (n,), with the interval of `mean_rate` over groups."""
    total = Rate(int(successes.sum()), int(attempts.sum()))
    if len(attempts) < 2:
        return Mean(total.successes, total.attempts, 0.0, 1.0)
    with np.errstate(invalid="ignore"):  # a draw may have only groups without attempts
        low, high = bootstrap(
            lambda drawn: successes[drawn].sum(axis=1) / attempts[drawn].sum(axis=1), len(attempts)
        )
    least, most = total.interval
    return Mean(total.successes, total.attempts, np.fmin(low, least), np.fmax(high, most))


def trial_grid(trials: pd.DataFrame, rows: int, columns: int) -> TrialGrid:
    """Success rates of objects, rows and columns, as in the paper; labels outside do not count."""
    if not in_grid(set(trials["label"])):
        return TrialGrid({}, [], [], mean_rate(trials))
    found = [cell_of_label(label) for label in trials["label"]]
    row, column = np.array(found, dtype=np.int64).reshape(-1, 2).T
    if (row >= rows).any() or (column >= columns).any():
        return TrialGrid({}, [], [], mean_rate(trials))
    cells = {(i, j): rate(trials[(row == i) & (column == j)]) for i, j in sorted(set(found))}
    return TrialGrid(
        cells,
        [mean_rate(trials[row == index]) for index in range(rows)],
        [mean_rate(trials[column == index]) for index in range(columns)],
        mean_rate(trials),
    )


@dataclass(frozen=True)
class Trend:
    """Spearman's rho with its 95 % interval over objects; NaN for fewer than `MIN_CORRELATED`."""

    rho: float
    ci_low: float
    ci_high: float


def object_positions(trials: pd.DataFrame, evalset: pd.DataFrame | None = None) -> pd.DataFrame:
    """Rate, difficulty (minus graspability, or row) and complexity (or column) by label."""
    objects = by_object(trials)
    table = pd.DataFrame({"rate": objects["successes"] / objects["attempts"]})
    known = None if evalset is None else evalset.set_index("label")
    if known is None or not table.index.isin(known.index).all():
        inside = in_grid(table.index)
        cells = [cell_of_label(label) if inside else (np.nan, np.nan) for label in table.index]
        keys = ["difficulty", "complexity"]
        table[keys] = np.array(cells, dtype=np.float64).reshape(-1, 2)
        return table
    table["difficulty"] = -known["graspability"].reindex(table.index)
    table["complexity"] = known["complexity"].reindex(table.index)
    return table


def trend(values: Floats, rates: Floats) -> Trend:
    """Spearman's rank correlation of property and rate, (n,), and its bootstrap over objects."""
    if len(values) < MIN_CORRELATED:
        return Trend(np.nan, np.nan, np.nan)
    everything = np.arange(len(values))[None]
    low, high = bootstrap(lambda drawn: rank_correlation(values[drawn], rates[drawn]), len(values))
    return Trend(float(rank_correlation(values[everything], rates[everything])[0]), low, high)


def rank_correlation(x: Floats, y: Floats) -> Floats:
    """Rank correlation of each row of x with that of y, (draws,); NaN if either is constant."""
    return correlation(*(scipy.stats.rankdata(values, axis=1) for values in (x, y)))


def correlation(x: Floats, y: Floats) -> Floats:
    """Pearson correlation of each row of x with that of y, (draws,); NaN if either is constant."""
    if x.shape[1] < 2:
        return np.full(len(x), np.nan)
    with warnings.catch_warnings(action="ignore", category=scipy.stats.ConstantInputWarning):
        found: Floats = scipy.stats.pearsonr(x, y, axis=1).statistic
    return found
