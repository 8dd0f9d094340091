"""Evidence from pairs of attempts that an object is a failure, valid after every pair.

Both tests are e-processes, that is, products of bets against a null hypothesis. Whatever the
stopping rule, the product reaches 1 / level with at most the probability `level` if the hypothesis
holds (Ville's inequality; Ramdas et al. 2023, "Game-theoretic statistics and safe anytime-valid
inference"). The bets are ours.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

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
