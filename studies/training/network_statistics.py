"""Comparison of training sets by the success of networks: the unit is the network."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import chi2, t, ttest_1samp, ttest_ind

from egad.bench.stats import Interval, bootstrap, by_object, clearing_rates
from egad.errors import UserError
from egad.tables import parquet

Floats = NDArray[np.float64]
UNKNOWN: Interval = (float("nan"), float("nan"))
TEST = ["test", "scene", "noise", "measure"]  # columns that name what is compared


@dataclass(frozen=True)
class Spread:
    """Standard deviation between networks of the same set.

    Attributes:
        sd: Estimate, pooled over the sets.
        interval: Its 95 % confidence interval, for normally distributed success.
        freedom: Networks minus sets.
    """

    sd: float
    interval: Interval
    freedom: int


@dataclass(frozen=True)
class Difference:
    """Mean success of the networks of one set minus that of another.

    Attributes:
        gain: The difference.
        interval: 95 % confidence interval for other trainings.
        p: Two-sided p-value; NaN if both have a single network.
    """

    gain: float
    interval: Interval
    p: float


@dataclass(frozen=True)
class SetComparison:
    """A pre-registered comparison in one test with single objects.

    Attributes:
        test: Dataset of the evaluation set.
        noise: Noise added to the depth images.
        first: Training set, or another detector.
        second: The one that it is compared with.
        networks: How many of each.
        difference: First minus second, over networks.
        p_holm: The p-value with Holm's correction for all pre-registered comparisons.
        by_objects: The second interval of the difference: by resampling objects, for these
            networks and other objects of the same kind.
    """

    test: str
    noise: str
    first: str
    second: str
    networks: tuple[int, int]
    difference: Difference
    p_holm: float
    by_objects: Interval


def network_rates(trials: pd.DataFrame, cleared: pd.DataFrame) -> pd.DataFrame:
    """How well each network did in each test.

    Args:
        trials: Columns of `study_tables.COMPARED`.
        cleared: Columns of `study_tables.CLEARED`.

    Returns:
        Columns test, scene, noise, measure (success: of attempts; cleared: of objects), name
        (training set, or other detector), trained (whether it is a set), seed, rate. The success of
        a network that proposed no grasp in a test is 0.
    """
    made_by = ["test", "training_set", "detector", "seed"]
    single = trials.groupby(["noise", *made_by], sort=False, as_index=False)["success"].mean()
    parts = [single.assign(scene="single", measure="success").rename(columns={"success": "rate"})]
    for _, rows in cleared.groupby(made_by, sort=False):
        clearings = clearing_rates(rows)
        shares = pd.DataFrame(
            [
                (each.scene, each.noise, measure, getattr(each, measure).value)
                for measure in ("success", "cleared")
                for each in clearings
            ],
            columns=[*TEST[1:], "rate"],
        )
        parts.append(shares.assign(**parquet.records(rows[made_by].head(1))[0]))
    table = pd.concat(parts, ignore_index=True)
    columns = [*TEST, "name", "trained", "seed", "rate"]
    named = table.assign(
        trained=table["training_set"] != "",
        name=set_or_detector(table),
        rate=table["rate"].fillna(0.0),
    )
    found: pd.DataFrame = named.loc[:, columns]
    return found


def set_or_detector(rows: pd.DataFrame) -> "pd.Series[str]":
    """The training set of each row, or the detector where there is none."""
    return rows["training_set"].where(rows["training_set"] != "", rows["detector"])


def by_name(rates: pd.DataFrame) -> dict[str, Floats]:
    """The rates of one test by training set or other detector, in the order of the table."""
    return {
        str(name): rows["rate"].to_numpy(np.float64)
        for name, rows in rates.groupby("name", sort=False)
    }


def pooled_spread(groups: Iterable[Sequence[float] | Floats]) -> Spread | None:
    """The standard deviation within sets, as if it were the same in all of them.

    Args:
        groups: Success of the networks of each set.

    Returns:
        None if no set has several networks.
    """
    several = [np.asarray(values) for values in groups if len(values) > 1]
    freedom = sum(len(values) - 1 for values in several)
    if not freedom:
        return None
    squares = sum(float(np.square(values - values.mean()).sum()) for values in several)
    low, high = np.sqrt(squares / chi2.ppf([0.975, 0.025], freedom))
    return Spread(float(np.sqrt(squares / freedom)), (float(low), float(high)), freedom)


def mean_interval(values: Sequence[float] | Floats, spread: Spread | None) -> Interval:
    """The 95 % confidence interval of the mean of all networks that could be trained on a set.

    Args:
        values: Success rates of its networks.
        spread: Between networks; pooled over all sets, it makes up for few networks per set.

    Returns:
        Both ends, clipped to 0 to 1; NaN if the spread is unknown, or 0 by chance.
    """
    mean, reach = float(np.mean(values)), _reach(spread, values)
    low, high = np.clip([mean - reach, mean + reach], 0.0, 1.0)
    return float(low), float(high)


def difference_interval(
    first: Sequence[float] | Floats, second: Sequence[float] | Floats, spread: Spread | None
) -> Interval:
    """The 95 % confidence interval of the mean of a set minus that of another one, as above.

    Args:
        first: Success rates of the networks of a set.
        second: The same of the other set.
        spread: Between networks, pooled over all sets.

    Returns:
        Both ends; NaN if the spread is unknown, or 0 by chance.
    """
    gain, reach = float(np.mean(first) - np.mean(second)), _reach(spread, first, second)
    return gain - reach, gain + reach


def _reach(spread: Spread | None, *sets: Sequence[float] | Floats) -> float:
    """Half the width of the 95 % interval of a sum or difference of the means of these sets."""
    if spread is None or not spread.sd:
        return float("nan")
    networks = sum(1 / len(values) for values in sets)
    return float(t.ppf(0.975, spread.freedom) * spread.sd * np.sqrt(networks))


def difference(first: Sequence[float] | Floats, second: Sequence[float] | Floats) -> Difference:
    """Compare the networks of two sets by Welch's t test.

    If one has a single network, as given weights and other detectors do, the test is whether
    networks of the other set are better or worse than this one (one-sample t test).

    Args:
        first: Success of the networks of a set.
        second: The same of the other set.
    """
    gain = float(np.mean(first) - np.mean(second))
    if len(first) == len(second) == 1:
        return Difference(gain, UNKNOWN, float("nan"))
    if len(first) == 1:
        turned = difference(second, first)
        low, high = turned.interval
        return Difference(gain, (-high, -low), turned.p)
    if len(second) == 1:
        found = ttest_1samp(np.asarray(first) - second[0], 0)
    else:
        found = ttest_ind(first, second, equal_var=False)
    interval = found.confidence_interval(0.95)
    return Difference(gain, (float(interval.low), float(interval.high)), float(found.pvalue))


def compare_sets(
    trials: pd.DataFrame, comparisons: Iterable[tuple[str, str]]
) -> list[SetComparison]:
    """The pre-registered comparisons in all tests with single objects, with Holm's correction.

    Args:
        trials: Columns of `study_tables.COMPARED`.
        comparisons: Pairs of training sets or other detectors.
    """
    named = trials.assign(name=set_or_detector(trials))
    found = [
        _compared(str(test), str(noise), rows, *pair)
        for (test, noise), rows in named.groupby(["test", "noise"], sort=False)
        for pair in comparisons
    ]
    corrected = holm(np.array([each.difference.p for each in found]))
    return [replace(each, p_holm=float(p)) for each, p in zip(found, corrected, strict=True)]


def _compared(test: str, noise: str, rows: pd.DataFrame, first: str, second: str) -> SetComparison:
    """Two sets in a test, as if there were no other comparison."""
    one, other = (rows[rows["name"] == name] for name in (first, second))
    rates = [each.groupby("seed")["success"].mean().to_numpy() for each in (one, other)]
    result = difference(*rates)
    counts = len(rates[0]), len(rates[1])
    by_objects = object_interval(one, other)
    return SetComparison(test, noise, first, second, counts, result, result.p, by_objects)


def object_interval(first: pd.DataFrame, second: pd.DataFrame) -> Interval:
    """The interval of a difference of success for these networks and other objects.

    Objects are drawn with replacement, each with all attempts of all networks (`bootstrap`).

    Args:
        first: Columns label and success.
        second: The same; all objects have the same number of attempts within a table.
    """
    one, other = (by_object(rows) for rows in (first, second))
    gains = (one["successes"] / one["attempts"] - other["successes"] / other["attempts"]).to_numpy()
    return bootstrap(lambda drawn: gains[drawn].mean(axis=1), len(gains))


def holm(p_values: Floats) -> Floats:
    """Adjust p-values of several tests: any is below 0.05 by chance in at most 5 % of cases.

    The smallest of n is multiplied by n, the next by n - 1 and so on, and none is less than the
    one before it (Holm 1979).

    Args:
        p_values: (n,); NaN counts as a test without a result.

    Returns:
        (n,) at most 1; NaN where it was.
    """
    order = np.argsort(p_values)  # NaN last
    steps = p_values[order] * np.arange(len(p_values), 0, -1)
    found = np.empty(len(p_values))
    found[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return found


def check_starts(rows: pd.DataFrame) -> None:
    """Refuse attempts that should start from the same drop and do not.

    An attempt at an object that cannot be simulated has no initial pose.

    Args:
        rows: Columns label, attempt, initial_pose and detector, of one test.

    Raises:
        UserError: A detector met an object in a different pose than the detectors before it.
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
