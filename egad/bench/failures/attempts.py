"""Evaluating tables of simulated attempts at objects."""

import numpy as np
import pandas as pd

from egad.bench.failures.evidence import PairedDrop
from egad.sim import ENGINES


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


def counts_of(attempts: pd.DataFrame, purpose: str = "confirm") -> dict[str, float]:
    """Results of the fresh drops at an object, by engine: columns of `tables.failures.EXAMINED`."""
    values: dict[str, float] = {}
    for engine in ENGINES:
        pairs = pairs_of(attempts, engine, purpose)
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
    """Why a detector fails at an object: columns of `tables.failures.EXPLAINED`.

    `Examination.explain` tried other proposals in this engine, at `most` drops.
    """
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
