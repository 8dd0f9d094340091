"""What became of an archive, step by step."""

import math
from collections import Counter
from typing import Any

import numpy as np

from egad.map_elites.archive import Archive

EVALUATED, EMPTY, KNOWN = "evaluated", "empty", "known already"


def snapshot(archive: Archive, outcomes: Counter[str], scored: bool) -> dict[str, Any]:
    """What a step did: columns of `tables.evolution.HISTORY` but for the names of the step.

    Args:
        archive: After the step.
        outcomes: How many offspring were evaluated, empty, known already, or rejected for which
            reason.
        scored: Whether to compute the QD-score, which asks for all diversities.
    """
    counts = archive.counts()
    return {
        "offspring": outcomes.total(),
        "evaluated": outcomes[EVALUATED],
        "empty": outcomes[EMPTY],
        "known": outcomes[KNOWN],
        "elites": len(archive),
        "coverage": archive.coverage,
        "filled_cells": float((counts > 0).mean()),
        "qd_score": archive.qd_score if scored else math.nan,
        "cells": counts.astype(np.uint8).tobytes(),
    }
