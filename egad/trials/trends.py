"""How success falls with the difficulty and the complexity of objects."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import rankdata

from egad.evalset.labels import place
from egad.trials.statistics import bootstrap, by_object

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Trend:
    """A rank correlation.

    Attributes:
        rho: Spearman's coefficient; NaN if all objects are the same in either.
        low: Lower end of its interval of 95 %, for other objects of the same kind.
        high: Upper end.
    """

    rho: float
    low: float
    high: float


def places(trials: pd.DataFrame, evalset: pd.DataFrame | None = None) -> pd.DataFrame:
    """Success, difficulty and complexity of each object tried, by its label.

    Args:
        trials: Columns label and success.
        evalset: Columns of `tables.evaluation.EVAL49`. Without it, or where it lacks an object,
            the row of a label stands for difficulty and its column for complexity.

    Returns:
        Columns rate; difficulty, high for hard objects: the grasp quality of the set, negative;
        and complexity.
    """
    objects = by_object(trials)
    table = pd.DataFrame({"rate": objects["successes"] / objects["attempts"]})
    known = None if evalset is None else evalset.set_index("label")
    if known is None or not table.index.isin(known.index).all():
        rows = [place(str(label)) for label in table.index]
        table["difficulty"] = [float(row) for row, _ in rows]
        table["complexity"] = [float(column) for _, column in rows]
        return table
    table["difficulty"] = -known["difficulty"].reindex(table.index)
    table["complexity"] = known["complexity"].reindex(table.index)
    return table


def trend(values: Floats, rates: Floats) -> Trend:
    """Spearman's rank correlation of n objects, with an interval by bootstrap over them.

    Args:
        values: (n,) what may make objects hard.
        rates: (n,) how often each was held.
    """
    everything = np.arange(len(values))[None]
    low, high = bootstrap(lambda drawn: _spearman(values[drawn], rates[drawn]), len(values))
    return Trend(float(_spearman(values[everything], rates[everything])[0]), low, high)


def _spearman(x: Floats, y: Floats) -> Floats:
    """Rank correlation of each row of x with that of y, (draws,); NaN if either is constant."""
    if x.shape[1] == 0:
        return np.full(len(x), np.nan)
    a, b = (rankdata(values, axis=1) for values in (x, y))
    a, b = (ranks - ranks.mean(axis=1, keepdims=True) for ranks in (a, b))
    scale = np.sqrt((a**2).sum(axis=1) * (b**2).sum(axis=1))
    defined = scale > 0
    rho: Floats = np.full(len(x), np.nan)
    rho[defined] = (a * b).sum(axis=1)[defined] / scale[defined]
    return rho
