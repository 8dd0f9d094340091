"""The verdict on an object for a detector, and the attempts that led to it."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import pandas as pd

from egad.bench.failures.attempts import pairs_of
from egad.bench.failures.evidence import PairedDrop


class ObjectVerdict(StrEnum):
    """The verdict on an object for a detector."""

    FAILURE = "failure"
    DETECTOR_SUCCEEDS = "detector_succeeds"
    NOT_GRASPABLE = "not_graspable"
    NOT_PRINTABLE = "not_printable"
    NOT_CONFIRMED = "not_confirmed"
    NOT_SIMULATED = "not_simulated"
    NOT_MEASURED = "not_measured"
    CELL_FULL = "cell_full"


GRASPABLE = (
    ObjectVerdict.FAILURE,
    ObjectVerdict.DETECTOR_SUCCEEDS,
    ObjectVerdict.NOT_CONFIRMED,
)


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
        """The objective of the search: the difference, shrunk towards 0, in steps of 0.1.

        It is the lowest over engines with fresh drops, else that of all attempts of the detector.
        """
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
