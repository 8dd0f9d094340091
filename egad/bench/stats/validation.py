"""Simulated against real success rates: object by object, and detector by detector."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from egad._util.arrays import Floats, Ints
from egad.bench.stats.paired import NothingInCommonError
from egad.bench.stats.prediction_powered import MIN_OBJECTS, PredictedRate, prediction_powered_rate
from egad.bench.stats.rates import MIN_CORRELATED, bootstrap, correlation, rank_correlation

CHUNK = 4_000_000  # pairs of rates compared at once
FEW_DETECTORS = 5  # correlations of fewer say almost nothing


class Estimate(NamedTuple):
    """A number with its 95 % confidence interval over objects; NaN where there is none."""

    value: float
    ci_low: float
    ci_high: float


UNKNOWN = Estimate(np.nan, np.nan, np.nan)


@dataclass(frozen=True)
class Agreement:
    """How well simulated success rates of `count` objects or detectors agree with real ones.

    `difference` is real minus simulated. Correlations are NaN for fewer than `MIN_CORRELATED`. The
    interval of `mmrv` is biased low, as draws with replacement have fewer different objects.
    `limit` is the Pearson correlation of an exact simulation with as many attempts at each object;
    NaN if that number is not known, and for detectors.
    """

    count: int
    simulated: float
    real: float
    difference: Estimate
    spearman: Estimate
    pearson: Estimate
    mmrv: Estimate
    limit: float


@dataclass(frozen=True)
class Validation:
    """Detectors in simulation against the same detectors on a robot."""

    objects: dict[str, Agreement]  # agreement over the objects that both tried, by detector
    # agreement over the detectors, on objects that all of them tried on both sides; None if
    # there is only one, or no such object
    detectors: Agreement | None
    # real rate with the help of objects that were only simulated, by detector; only for
    # detectors with enough objects on both sides and some that were only simulated
    predicted: dict[str, PredictedRate]
    notes: list[str]  # sentences on what was left out, and on what to be careful about


def validate(simulated: Mapping[str, pd.DataFrame], real: Mapping[str, pd.DataFrame]) -> Validation:
    """Compare simulated with real tables of `read_rates`, matched by detector and object.

    A single detector on each side is the same, whatever its name. Intervals are by bootstrap over
    objects, without the noise of few attempts, which lowers correlations by as much as
    `Agreement.limit` says. NothingInCommonError if no detector has an object on both sides.
    """
    matched, notes = _match(simulated, real)
    predicted = {}
    for name, (sim, rob) in matched.items():
        both = sim.index.intersection(rob.index)
        more = sim["rate"].drop(both).to_numpy()
        if len(both) < MIN_CORRELATED:
            notes.append(
                f"{name}: {len(both)} common objects are too few for correlations (at least "
                f"{MIN_CORRELATED})"
            )
        if len(both) < MIN_OBJECTS:
            notes.append(
                f"{name}: {len(both)} common objects are too few to predict the real success rate "
                f"(at least {MIN_OBJECTS})"
            )
        elif len(more):
            real_rates, sim_rates = (table.loc[both, "rate"].to_numpy() for table in (rob, sim))
            predicted[name] = prediction_powered_rate(real_rates, sim_rates, more)
    return Validation(
        {name: _object_agreement(*pair) for name, pair in matched.items()},
        _detector_agreement(matched, notes),
        predicted,
        notes,
    )


def _match(
    simulated: Mapping[str, pd.DataFrame], real: Mapping[str, pd.DataFrame]
) -> tuple[dict[str, tuple[pd.DataFrame, pd.DataFrame]], list[str]]:
    """Tables of the same detectors, and notes on what has no counterpart."""
    names = {name: name for name in simulated if name in real}
    if len(simulated) == len(real) == 1:
        names = {next(iter(simulated)): next(iter(real))}
    if not names:
        raise NothingInCommonError(
            f"no detector is on both sides: simulated {', '.join(simulated)}; "
            f"real {', '.join(real)}"
        )
    notes = [f"{name}: only simulated" for name in simulated if name not in names]
    notes += [f"{name}: only real" for name in real if name not in names.values()]
    found = {}
    for name, other in names.items():
        pair = simulated[name], real[other]
        if missing := sorted(set(pair[1].index) - set(pair[0].index)):
            notes.append(f"{name}: real objects that were not simulated: {_few(missing)}")
        if len(pair[0].index.intersection(pair[1].index)):
            found[name] = pair
    if not found:
        sides = (f"{side} {_few(labels)}" for side, labels in _labels(simulated, real, names))
        raise NothingInCommonError(f"no object is on both sides: {'; '.join(sides)}")
    return found, notes


def _labels(
    simulated: Mapping[str, pd.DataFrame],
    real: Mapping[str, pd.DataFrame],
    names: Mapping[str, str],
) -> Iterator[tuple[str, list[str]]]:
    """The objects of both sides, for messages."""
    for side, tables in (
        ("simulated", [simulated[name] for name in names]),
        ("real", [real[name] for name in names.values()]),
    ):
        yield side, sorted({str(label) for table in tables for label in table.index})


def _few(names: Sequence[str]) -> str:
    return ", ".join(names[:5]) + (", ..." if len(names) > 5 else "")


def _object_agreement(simulated: pd.DataFrame, real: pd.DataFrame) -> Agreement:
    """Agreement over the objects that a detector tried on both sides."""
    both = simulated.index.intersection(real.index)
    sim, rob = simulated.loc[both], real.loc[both]
    pair = sim["rate"].to_numpy(), rob["rate"].to_numpy()
    limit = float(np.sqrt(_reliability(sim) * _reliability(rob)))
    result = _agreement(lambda drawn: (pair[0][drawn], pair[1][drawn]), len(both), limit)
    if len(both) < MIN_CORRELATED:
        return replace(result, spearman=UNKNOWN, pearson=UNKNOWN, limit=np.nan)
    return result


def _detector_agreement(
    matched: Mapping[str, tuple[pd.DataFrame, pd.DataFrame]], notes: list[str]
) -> Agreement | None:
    """Agreement over detectors of mean rates on objects that all of them tried on both sides."""
    if len(matched) < 2:
        notes.append(
            "one detector: it takes several to tell whether the simulation ranks detectors "
            "correctly"
        )
        return None
    tables = [table for pair in matched.values() for table in pair]
    both = sorted(set.intersection(*(set(table.index) for table in tables)))
    if not both:
        notes.append("no object was tried by all detectors on both sides")
        return None
    if len(matched) < FEW_DETECTORS:
        notes.append(f"{len(matched)} detectors are too few for correlations to say much")
    sides = [np.array([pair[i].loc[both, "rate"] for pair in matched.values()]) for i in (0, 1)]

    def means(drawn: Ints) -> tuple[Floats, Floats]:
        one, other = (side[:, drawn].mean(axis=2).T.round(12) for side in sides)  # keeps ties
        return one, other

    return _agreement(means, len(both), float("nan"))


def _agreement(
    rates_of: Callable[[Ints], tuple[Floats, Floats]], objects: int, limit: float
) -> Agreement:
    """Agreement of the simulated and real rates (draws, k) of objects that are drawn."""

    def estimate(statistic: Callable[[Floats, Floats], Floats]) -> Estimate:
        value = float(statistic(*rates_of(np.arange(objects)[None]))[0])
        return Estimate(value, *bootstrap(lambda drawn: statistic(*rates_of(drawn)), objects))

    simulated, real = rates_of(np.arange(objects)[None])
    return Agreement(
        count=simulated.shape[1],
        simulated=float(simulated.mean()),
        real=float(real.mean()),
        difference=estimate(lambda sim, rob: (rob - sim).mean(axis=1)),
        spearman=estimate(rank_correlation),
        pearson=estimate(correlation),
        mmrv=estimate(mmrv),
        limit=limit,
    )


def mmrv(simulated: Floats, real: Floats) -> Floats:
    """Mean maximum rank violation of SIMPLER (Li and others 2024), 0 to 1, of rates (..., n).

    For each object or detector, it takes the others that the simulation orders differently from
    reality, and the largest difference of real rates among these; the result is the mean. Real
    differences are what counts: a swap of two that are nearly equal on the robot matters little,
    however large the simulated difference. The published function takes (simulated, real), but its
    documentation has them the other way round, which weights by simulated differences.
    """
    flat = [rates.reshape(-1, rates.shape[-1]) for rates in np.broadcast_arrays(simulated, real)]
    count = flat[0].shape[1]
    step = max(CHUNK // max(count * count, 1), 1)
    found = [
        _violations(*(rates[start : start + step] for rates in flat))
        for start in range(0, len(flat[0]), step)
    ]
    means: Floats = np.concatenate(found).reshape(np.shape(real)[:-1])
    return means


def _violations(simulated: Floats, real: Floats) -> Floats:
    """The same for (draws, n) rates."""
    orders = [rates[:, :, None] > rates[:, None, :] for rates in (simulated, real)]
    gaps = np.abs(real[:, :, None] - real[:, None, :])
    worst: Floats = np.where(orders[0] != orders[1], gaps, 0.0).max(axis=2).mean(axis=1)
    return worst


def _reliability(table: pd.DataFrame) -> float:
    """Share of the variance over objects that is not noise of few attempts; NaN if unknown."""
    rate, attempts = table["rate"], table["attempts"]
    variance = rate.var()
    if not variance > 0 or not (attempts > 1).all():
        return float("nan")
    noise = (rate * (1 - rate) / (attempts - 1)).mean()
    return float(max(1 - noise / variance, 0.0))
