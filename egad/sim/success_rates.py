"""What simulated grasps tell about their objects."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.tables.grasping import NAIVE_RATES
from egad.tables.outcomes import SIMULATION_FAILURES, Outcome

FREE, TABLE = "free", "table"  # where an object is when naive grasps are tried

SHAKEN_AND_HELD = tuple(
    outcome.value for outcome in (Outcome.SUCCESS, Outcome.SLIPPED_LIFTING, Outcome.DROPPED)
)
"""Outcomes of grasps that held while the object was shaken."""


def with_outcome(grasps: pd.DataFrame) -> pd.DataFrame:
    """The grasps that were simulated, and those at which the open hand collides."""
    return grasps[grasps["simulated_success"].notna() | ~grasps["collision_free"]]


def held_when_shaken(grasps: pd.DataFrame) -> NDArray[np.bool_]:
    """Whether both fingers still held the object after it was shaken in simulation, (n,)."""
    return grasps["simulated_outcome"].isin(SHAKEN_AND_HELD).to_numpy(dtype=bool)


def antipodal_success_rates(grasps: pd.DataFrame) -> pd.DataFrame:
    """How often simulated antipodal grasps with an outcome succeeded: `ANTIPODAL_RATES` (ours)."""
    known = grasps[grasps["simulated_success"].notna()]
    marked = known.assign(
        success=known["simulated_success"].astype(float),
        shaken=known["simulated_outcome"].isin(SHAKEN_AND_HELD),
    )
    found = marked.groupby(["label", "id"], as_index=False).agg(
        n_simulated=("success", "size"),
        antipodal_success_rate=("success", "mean"),
        held_shaking=("shaken", "mean"),
        simulated_engine=("simulated_engine", "first"),
    )
    return found.sort_values("label", ignore_index=True)


class SuccessRate(NamedTuple):
    """How often grasps succeeded."""

    n: int  # number of grasps that the engine could judge
    rate: float  # number that succeeded / n; NaN if n is 0
    std: float  # standard error of the rate


def success_rate(outcomes: Iterable[str]) -> SuccessRate:
    """Success rate of independent grasps, from their values of `Outcome`."""
    known = [each == Outcome.SUCCESS for each in outcomes if each not in SIMULATION_FAILURES]
    if not known:
        return SuccessRate(0, np.nan, np.nan)
    rate = sum(known) / len(known)
    return SuccessRate(len(known), rate, float(np.sqrt(rate * (1 - rate) / len(known))))


def naive_success_rates(tried: pd.DataFrame) -> pd.DataFrame:
    """How often the naive grasps (`NAIVE_GRASPS`) of each object succeeded: `NAIVE_RATES`."""
    rows = []
    for (label, name), grasps in tried.groupby(["label", "id"]):
        row = {"id": name, "label": label, "naive_engine": grasps["engine"].iloc[0]}
        for place, column in ((FREE, "simulated_success_rate"), (TABLE, "table_success_rate")):
            found = success_rate(grasps["outcome"][grasps["place"] == place])
            row |= {f"n_{place}": found.n, column: found.rate, f"{column}_std": found.std}
        rows.append(row)
    return pd.DataFrame(rows, columns=NAIVE_RATES.names)
