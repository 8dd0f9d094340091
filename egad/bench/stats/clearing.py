"""How well detectors clear tables: success rates and shares of objects that are cleared."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from egad._util.arrays import Floats, Ints
from egad.bench.stats.paired import NothingInCommonError, sign_flip
from egad.bench.stats.rates import Interval, Mean, bootstrap, mean_of
from egad.tables.outcomes import SIMULATION_FAILURES, Outcome

SCENE = ["round", "seed", "objects", "factors", "n_objects"]  # the initial scene of a round
UNTRIED = (Outcome.NO_GRASP, *SIMULATION_FAILURES)


class Clearing(NamedTuple):
    """How well a detector clears scenes of one kind, with one kind of noise: rates over rounds."""

    scene: str
    noise: str
    rounds: int
    success: Mean
    cleared: Mean


def clearing_rates(table: pd.DataFrame) -> list[Clearing]:
    """Rates of each kind of scene and noise of the rounds that began, with 95 % intervals."""
    return [_rates(*key, _rounds(rows)) for key, rows in _groups(table)]


class ClearingComparison(NamedTuple):
    """The first of two detectors minus the second, over rounds that began with the same scene.

    Intervals are of 95 %, by resampling rounds; `p_cleared` is from `sign_flip` over rounds.
    """

    scene: str
    noise: str
    rounds: int
    success: float
    success_interval: Interval
    cleared: float
    cleared_interval: Interval
    p_cleared: float


def compare_clearing(first: pd.DataFrame, second: pd.DataFrame) -> list[ClearingComparison]:
    """Compare two tables, `tables.clutter.CLUTTER`; NothingInCommonError if they share no round."""
    one, other = ({key: _rounds(rows) for key, rows in _groups(each)} for each in (first, second))
    pairs = {key: one[key].merge(other[key], on=SCENE) for key in one if key in other}
    found = [_compared(*key, rounds) for key, rounds in pairs.items() if len(rounds)]
    if not found:
        raise NothingInCommonError(
            "the two tables have no round in common: same scene, noise, objects and seed"
        )
    return found


def by_difficulty(table: pd.DataFrame, objects: pd.DataFrame) -> pd.DataFrame:
    """Successes, attempts and presence by thirds of the objects, by complexity and difficulty."""
    tried = table[table["id"] != ""]
    first = table[table["attempt"] == 0]
    there = [name for names in first["present"] for name in names.split()]
    found = []
    for axis, measure in (("complexity", "complexity"), ("difficulty", "graspability")):
        rank = objects.set_index("id")[measure].rank(pct=True, ascending=axis == "complexity")
        band = np.ceil(rank.reindex(tried["id"]).to_numpy() * 3)
        band_there = np.ceil(rank.reindex(there).to_numpy() * 3)
        for number in (1, 2, 3):
            rows = tried[band == number]
            present = int((band_there == number).sum())
            found.append((axis, number, int(rows["success"].sum()), len(rows), present))
    return pd.DataFrame(found, columns=["axis", "band", "successes", "attempts", "present"])


def _groups(table: pd.DataFrame) -> Iterator[tuple[tuple[str, str], pd.DataFrame]]:
    """The rows of each kind of scene and noise."""
    began = table[table["n_objects"] > 0]
    for (scene, noise), rows in began.groupby(["scene", "noise"], sort=False):
        yield (str(scene), str(noise)), rows


def _rounds(rows: pd.DataFrame) -> pd.DataFrame:
    """Successes and attempts of each round, with the columns `SCENE`."""
    tried = rows.assign(tried=~rows["outcome"].isin(UNTRIED))
    return tried.groupby(SCENE, as_index=False)[["success", "tried"]].sum()


def _rates(scene: str, noise: str, rounds: pd.DataFrame) -> Clearing:
    successes, tried, present = _counts(rounds, "success", "tried", "n_objects")
    return Clearing(
        scene, noise, len(rounds), mean_of(successes, tried), mean_of(successes, present)
    )


def _compared(scene: str, noise: str, rounds: pd.DataFrame) -> ClearingComparison:
    one, other, tried, other_tried, present = _counts(
        rounds, "success_x", "success_y", "tried_x", "tried_y", "n_objects"
    )

    def success(drawn: Ints) -> Floats:
        with np.errstate(invalid="ignore"):  # a draw may have only rounds without attempts
            first = one[drawn].sum(axis=1) / tried[drawn].sum(axis=1)
            second = other[drawn].sum(axis=1) / other_tried[drawn].sum(axis=1)
        return np.asarray(first - second)

    def cleared(drawn: Ints) -> Floats:
        with np.errstate(invalid="ignore"):
            return np.asarray((one - other)[drawn].sum(axis=1) / present[drawn].sum(axis=1))

    all_rounds = np.arange(len(rounds))[None]
    return ClearingComparison(
        scene,
        noise,
        len(rounds),
        float(success(all_rounds)[0]),
        bootstrap(success, len(rounds)),
        float(cleared(all_rounds)[0]),
        bootstrap(cleared, len(rounds)),
        sign_flip(one - other),
    )


def _counts(rounds: pd.DataFrame, *names: str) -> list[Ints]:
    return [rounds[name].to_numpy(dtype=np.int64) for name in names]
