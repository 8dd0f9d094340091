"""How many attempts show a difference between two detectors, by simulation over objects."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations

import numpy as np
import pandas as pd
import scipy  # its modules are loaded when they are used

from egad._util.arrays import Floats
from egad.bench.stats.paired import sign_flip
from egad.bench.stats.rates import by_object
from egad.bench.stats.sequential import log_e_values, two_sided
from egad.errors import UserError
from egad.random import generator

CHUNK = 1_000_000  # pairs simulated at once
NORMAL: Floats = np.linspace(-6, 6, 2401)


@dataclass(frozen=True)
class ObjectRates:
    """How success rates of two detectors vary over objects: correlated beta distributions.

    What is hard for one detector is hard for others. In simulated trials on the released evaluation
    set, the standard deviation over objects is 0.29 to 0.36; the correlation of equally good
    detectors is 0.66 to 0.99, of detectors of different kinds up to 0.69.
    """

    mean: float = 0.6
    spread: float = 0.3
    correlation: float = 0.7

    def __post_init__(self) -> None:
        """Check the numbers; UserError if one is out of range."""
        if not 0 < self.mean < 1:
            raise UserError(
                f"the mean rate is {100 * self.mean:g} %; allowed: above 0 and below 100 %"
            )
        most = np.sqrt(self.mean * (1 - self.mean))
        if not 0 <= self.spread < most:
            raise UserError(
                f"the rates vary by {100 * self.spread:g} percentage points; allowed for a mean of "
                f"{100 * self.mean:g} %: at least 0, below {100 * most:.3g}"
            )
        if not 0 <= self.correlation <= 1:
            raise UserError(f"the correlation is {self.correlation:g}; allowed: 0 to 1")

    def sample(
        self, shape: tuple[int, ...], difference: float, rng: np.random.Generator
    ) -> tuple[Floats, Floats]:
        """True rates of both detectors at random objects, with this mean difference."""
        one, other = rng.standard_normal((2, *shape))
        other = self._copula * one + np.sqrt(1 - self._copula**2) * other
        return self._rates(difference / 2, one), self._rates(-difference / 2, other)

    @cached_property
    def _copula(self) -> float:
        """Correlation of normal numbers that gives the rates theirs, by Gaussian quadrature."""
        if not self.spread:
            return self.correlation
        nodes, weights = np.polynomial.hermite_e.hermegauss(64)
        one, other = np.meshgrid(nodes, nodes)
        weights = np.outer(weights, weights) / weights.sum() ** 2
        offsets = self._rates(0.0, one) - self.mean

        def covariance(copula: float) -> float:
            mixed = copula * one + np.sqrt(1 - copula**2) * other
            return float((weights * offsets * (self._rates(0.0, mixed) - self.mean)).sum())

        wanted = self.correlation * covariance(1.0)
        return float(scipy.optimize.brentq(lambda c: covariance(c) - wanted, -1.0, 1.0, xtol=1e-4))

    def _rates(self, above: float, normal: Floats) -> Floats:
        mean = self.mean + above
        if not self.spread:
            return np.full(normal.shape, mean)
        size = self.mean * (1 - self.mean) / self.spread**2 - 1
        return np.interp(normal, NORMAL, _beta_quantiles(mean * size, (1 - mean) * size))


@lru_cache(maxsize=64)
def _beta_quantiles(a: float, b: float) -> Floats:
    """Quantiles of a beta distribution at the probabilities of the normal quantiles `NORMAL`."""
    quantiles: Floats = scipy.stats.beta.ppf(scipy.stats.norm.cdf(NORMAL), a, b)
    return quantiles


@dataclass(frozen=True)
class Plan:
    """Attempts that show a difference with the requested power, at some number of objects."""

    objects: int
    attempts: int | None  # attempts of each detector at each object; None if the maximum is too low
    power: float  # probability that the test over objects then finds the better detector
    # total attempts of each detector after which the sequential test has found it with the
    # requested power, if objects are tried in rounds; None as above
    sequential: int | None
    median: int | None  # attempts after which it has found it in half of the cases


def fit_object_rates(tables: Sequence[pd.DataFrame]) -> ObjectRates:
    """Rates over objects from attempts of detectors, without the binomial part of their spread."""
    found = [by_object(table) for table in tables]
    found = [counts[counts["attempts"] > 1] for counts in found]
    if any(len(counts) < 2 for counts in found):
        raise UserError("rates over objects need at least two objects with two attempts each")
    rates = [counts["successes"] / counts["attempts"] for counts in found]
    noise = [
        (rate * (1 - rate) / (counts["attempts"] - 1)).mean()
        for rate, counts in zip(rates, found, strict=True)
    ]
    spreads = [np.sqrt(max(rate.var() - n, 0)) for rate, n in zip(rates, noise, strict=True)]
    correlations = [
        np.clip(rates[i].cov(rates[j]) / (spreads[i] * spreads[j]), 0, 1)
        for i, j in combinations(range(len(rates)), 2)
        if spreads[i] * spreads[j] > 0 and len(rates[i].index.intersection(rates[j].index)) > 1
    ]
    mean = float(np.mean([rate.mean() for rate in rates]))
    return ObjectRates(
        mean,
        float(min(np.mean(spreads), 0.99 * np.sqrt(mean * (1 - mean)))),
        float(np.mean(correlations)) if correlations else ObjectRates.correlation,
    )


def plan_attempts(
    objects: int,
    rates: ObjectRates,
    *,
    difference: float = 0.1,
    power: float = 0.8,
    level: float = 0.05,
    most: int = 100,
    runs: int = 500,
    seed: int = 0,
) -> Plan:
    """Find the number of attempts that show a difference between two detectors.

    Objects and attempts are simulated, and compared by the sign-flip test over objects that
    `compare` uses, and by `sequential_test`, both two-sided. A result counts only if the better
    detector is found, not the other one.

    Args:
        objects: Number of objects that both detectors try.
        rates: How success rates vary over objects.
        difference: Difference between the mean rates of the two detectors.
        power: Required probability of finding it.
        level: Level of the tests.
        most: Maximum number of attempts at each object.
        runs: Simulated comparisons; with 500, a power of 0.8 has a standard error of 0.018.
        seed: Seed of the simulation.

    Raises:
        UserError: A number is out of range.
    """
    largest = 2 * min(rates.mean, 1 - rates.mean)
    if not 0 < difference < largest:
        raise UserError(
            f"the difference is {100 * difference:g} percentage points; allowed for a mean of "
            f"{100 * rates.mean:g} %: above 0, below {100 * largest:.3g}"
        )
    for name, value in (("power", power), ("level", level)):
        if not 0 < value < 1:
            raise UserError(f"the {name} is {value:g}; allowed: above 0 and below 1")
    for name, count in (("objects", objects), ("most", most), ("runs", runs)):
        if count < 1:
            raise UserError(f"{name} is {count}; allowed: a whole number, at least 1")

    design = _Design(objects, rates, difference, level, runs, seed)
    attempts, reached = _least(design.power, power, most)
    stops = design.stops(most)
    return Plan(objects, attempts, reached, _quantile(stops, power), _quantile(stops, 0.5))


@dataclass(frozen=True)
class _Design:
    """Simulated comparisons of two detectors, the first of which is better."""

    objects: int
    rates: ObjectRates
    difference: float
    level: float
    runs: int
    seed: int

    @cached_property
    def _objects(self) -> tuple[Floats, Floats]:
        """True rates of both detectors, (runs, objects); the same for any number of attempts."""
        rng = generator(self.seed, "power", self.objects)
        return self.rates.sample((self.runs, self.objects), self.difference, rng)

    def power(self, attempts: int) -> float:
        """How often the test over objects finds the better one."""
        rng = generator(self.seed, "power", self.objects, attempts)
        one, other = self._objects
        gains = rng.binomial(attempts, one) - rng.binomial(attempts, other)
        wins = gains[gains.sum(axis=1) > 0]
        return sum(sign_flip(each) <= self.level for each in wins) / self.runs

    def stops(self, rounds: int) -> Floats:
        """Pairs after which the test decides for the better one, (runs,); else infinite."""
        rng = generator(self.seed, "power", self.objects, "sequential")
        chunk = max(CHUNK // (rounds * self.objects), 1)
        sizes = [min(chunk, self.runs - done) for done in range(0, self.runs, chunk)]
        return np.concatenate([self._stops(size, rounds, rng) for size in sizes])

    def _stops(self, runs: int, rounds: int, rng: np.random.Generator) -> Floats:
        """The same for a part of the runs; every round has the objects in another order."""
        order = rng.permuted(np.tile(np.arange(self.objects), (runs, rounds, 1)), axis=2)
        order = order.reshape(runs, -1)
        chances = self.rates.sample((runs, self.objects), self.difference, rng)
        first, second = (
            rng.random(order.shape) < np.take_along_axis(each, order, axis=1) for each in chances
        )
        forwards, backwards = log_e_values(first, second), log_e_values(second, first)
        decided = two_sided(forwards, backwards) >= -np.log(self.level)
        when = decided.argmax(axis=1)[:, None]
        ahead = np.take_along_axis(forwards > backwards, when, axis=1)[:, 0]
        return np.where(decided.any(axis=1) & ahead, when[:, 0] + 1.0, np.inf)


def _least(power_of: Callable[[int], float], power: float, most: int) -> tuple[int | None, float]:
    """The fewest attempts with the required power, by bisection, and the power that they have."""
    low, high = 0, most
    reached = power_of(high)
    if reached < power:
        return None, reached
    while high - low > 1:
        middle = (low + high) // 2
        value = power_of(middle)
        if value >= power:
            high, reached = middle, value
        else:
            low = middle
    return high, reached


def _quantile(stops: Floats, share: float) -> int | None:
    """The number by which this share has stopped; None if it never does."""
    stop = np.sort(stops)[int(np.ceil(share * len(stops))) - 1]
    return int(stop) if np.isfinite(stop) else None
