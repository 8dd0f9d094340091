"""Evidence from attempts at an object that it is a failure, and the verdict.

The tests of pairs are e-processes, valid after every pair: products of bets against a null
hypothesis. Whatever the stopping rule, the product reaches 1 / level with at most the probability
`level` if the hypothesis holds (Ville's inequality; Ramdas et al. 2023, "Game-theoretic statistics
and safe anytime-valid inference"). The bets are ours.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple, Self

import numpy as np
import pandas as pd

from egad.sim import FAST_ENGINES

ODDS = 0.1  # fraction of the failures allowed by the null hypothesis that the bet expects
STAKE = 0.9  # of the largest bet that cannot lose everything


class PairedDrop(NamedTuple):
    """Two attempts from the same pose."""

    reference: bool
    detector: bool


class Claim(NamedTuple):
    """The claim that is tested."""

    reference: float = 0.8  # minimum success rate of the reference
    difference: float = 0.5  # minimum difference of the success rates of reference and detector
    confidence: float = 0.95  # confidence of each of the two

    def is_shown(self, pairs: Sequence[PairedDrop]) -> bool:
        """Whether the evidence suffices."""
        return bool(min(self.evidence(pairs)) >= self._needed)

    def is_hopeless(self, pairs: Sequence[PairedDrop], most: int) -> bool:
        """Whether the evidence cannot suffice, however the pairs up to `most` end."""
        best = [*pairs, *[PairedDrop(True, False)] * (most - len(pairs))]
        return not any(self.is_shown(best[:count]) for count in range(len(pairs), most + 1))

    def evidence(self, pairs: Sequence[PairedDrop]) -> tuple[float, float]:
        """Logarithms of the e-values against a worse reference, and against a lower difference."""
        won = np.array([pair.reference for pair in pairs], dtype=np.int64)
        lost = np.array([pair.detector for pair in pairs], dtype=np.int64)
        expected = 1 - ODDS * (1 - self.reference)
        gains = np.log([(1 - expected) / (1 - self.reference), expected / self.reference])
        stake = STAKE / (1 + self.difference)
        bets = np.log1p(stake * (won - lost - self.difference))
        return float(gains[won].sum()), float(bets.sum())

    @property
    def _needed(self) -> float:
        return -float(np.log(1 - self.confidence))


def by_object(attempts: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """The attempts at each object, by its id, in the order in which the objects first occur."""
    return {str(name): rows for name, rows in attempts.groupby("id", sort=False)}


def pairs_of(attempts: pd.DataFrame, engine: str, purpose: str = "confirm") -> list[PairedDrop]:
    """Results of reference and detector at the fresh drops of an object, in their order."""
    fresh = attempts[(attempts["purpose"] == purpose) & (attempts["engine"] == engine)]
    by_who = fresh.pivot_table(index="drop", columns="who", values="success", aggfunc="first")
    if by_who.empty:
        return []
    columns = (by_who[who].astype(bool) for who in ("reference", "detector"))
    return [PairedDrop(*pair) for pair in zip(*columns, strict=True)]


def counts_of(attempts: pd.DataFrame) -> dict[str, float]:
    """Results of the fresh drops at an object, by engine: columns of `tables.failures.EXAMINED`."""
    values: dict[str, float] = {}
    for engine in FAST_ENGINES:
        pairs = pairs_of(attempts, engine)
        difference = sum(pair.reference - pair.detector for pair in pairs)
        values |= {
            f"n_pairs_{engine}": len(pairs),
            f"reference_successes_{engine}": sum(pair.reference for pair in pairs),
            f"detector_successes_{engine}": sum(pair.detector for pair in pairs),
            f"only_reference_{engine}": sum(pair.reference > pair.detector for pair in pairs),
            f"only_detector_{engine}": sum(pair.detector > pair.reference for pair in pairs),
            f"difference_{engine}": difference / len(pairs) if pairs else np.nan,
        }
    return values


def failed_drops(attempts: pd.DataFrame, engine: str) -> list[int]:
    """Numbers of an object's fresh drops in an engine at which only the reference succeeded."""
    fresh = attempts[(attempts["purpose"] == "confirm") & (attempts["engine"] == engine)]
    won = {who: set(rows.loc[rows["success"], "drop"]) for who, rows in fresh.groupby("who")}
    return sorted(won.get("reference", set()) - won.get("detector", set()))


def explanation(attempts: pd.DataFrame, engine: str, most: int) -> dict[str, int]:
    """Why a detector fails at an object: columns of `EXPLAINED`, from at most `most` drops."""
    drops = failed_drops(attempts, engine)[:most]
    chosen = attempts[(attempts["who"] == "detector") & attempts["drop"].isin(drops)]
    first = chosen[(chosen["purpose"] == "confirm") & (chosen["engine"] == engine)]
    others = chosen[chosen["purpose"] == "explain"]
    nothing = int((first["pose"].map(len) == 0).sum())
    better = int(others.groupby("drop")["success"].any().sum())
    return {
        "n_explained": len(drops),
        "n_nothing": nothing,
        "n_not_chosen": better,
        "n_none_good": len(drops) - nothing - better,
    }


class ObjectVerdict(StrEnum):
    """The verdict on an object for a detector; its value is what tables hold."""

    meaning: str

    def __new__(cls, value: str, meaning: str = "") -> Self:
        """A member with its meaning."""
        member = str.__new__(cls, value)
        member._value_, member.meaning = value, meaning
        return member

    FAILURE = "failure", "the reference holds it, the detector does not"
    DETECTOR_SUCCEEDS = "detector_succeeds", "the detector holds it too often for a failure"
    NOT_GRASPABLE = "not_graspable", "the reference does not hold it, either"
    NOT_PRINTABLE = "not_printable", "it cannot be printed, because of its walls or its parts"
    NOT_CONFIRMED = "not_confirmed", "fresh drops did not show a failure in every engine"
    NOT_SIMULATED = "not_simulated", "it has no convex parts, or does not come to rest"
    NOT_MEASURED = "not_measured", "not tried: complexity or graspability could not be measured"
    CELL_FULL = "cell_full", "not tried: its cell was full of failures"


GRASPABLE = (ObjectVerdict.FAILURE, ObjectVerdict.DETECTOR_SUCCEEDS, ObjectVerdict.NOT_CONFIRMED)


@dataclass(frozen=True)
class Examined:
    """The result of examining an object."""

    verdict: ObjectVerdict
    reason: str  # its reason, if the counts do not show it
    # one row per simulated grasp, columns of `tables.failures.FAILURE_ATTEMPTS`
    attempts: pd.DataFrame

    def pairs(self, engine: str) -> list[PairedDrop]:
        """The fresh drops in an engine, as from `pairs_of`."""
        return pairs_of(self.attempts, engine)

    @property
    def objective(self) -> float:
        """The lowest difference over engines, shrunk towards 0, in steps of 0.1."""
        if self.verdict not in GRASPABLE:
            return 0.0
        table = self.attempts
        fresh = [pairs for engine in table["engine"].unique() if (pairs := self.pairs(engine))]
        if not fresh:
            detector = table[table["who"] == "detector"]
            fresh = [[PairedDrop(True, bool(each)) for each in detector["success"]]]
        return min(_shrunk(pairs) for pairs in fresh)


def _shrunk(pairs: Sequence[PairedDrop]) -> float:
    difference = sum(pair.reference - pair.detector for pair in pairs) / (len(pairs) + 2)
    return round(max(difference, 0.0), 1)
