"""How well a detector clears tables: success rate and share of objects that are cleared."""

from typing import NamedTuple

import numpy as np
import pandas as pd

from egad.outcomes import Outcome
from egad.stats.rates import Mean, mean_of


class Clearing(NamedTuple):
    """How well a detector clears scenes of one kind.

    Attributes:
        scene: How the objects lie.
        noise: Of the depth images.
        rounds: How many.
        success: Successes over attempts.
        cleared: Objects that were grasped over objects that were there.
    """

    scene: str
    noise: str
    rounds: int
    success: Mean
    cleared: Mean


def clearing_rates(table: pd.DataFrame) -> list[Clearing]:
    """Rates of each kind of scene and noise, with intervals of 95 % for other rounds.

    If no grasp is proposed, the round ends; that is no attempt. Rounds are drawn with replacement,
    see `mean_of`.

    Args:
        table: Columns of `tables.clutter.CLUTTER`.
    """
    groups = table.groupby(["scene", "noise"], sort=False)
    return [_rates(str(scene), str(noise), rows) for (scene, noise), rows in groups]


def by_difficulty(table: pd.DataFrame, objects: pd.DataFrame, thirds: int = 3) -> pd.DataFrame:
    """Successes and attempts by thirds of the objects by complexity and by difficulty.

    Args:
        table: Columns of `tables.clutter.CLUTTER`.
        objects: Columns `id`, `complexity`, `difficulty` of all objects; a high stored difficulty
            is easy.
        thirds: How many bands.
    """
    tried = table[table["id"] != ""]
    found = []
    for axis in ("complexity", "difficulty"):
        rank = objects.set_index("id")[axis].rank(pct=True, ascending=axis == "complexity")
        band = np.ceil(rank.reindex(tried["id"]).to_numpy() * thirds)
        for number in range(1, thirds + 1):
            rows = tried[band == number]
            found.append((axis, number, int(rows["success"].sum()), len(rows)))
    return pd.DataFrame(found, columns=["axis", "band", "successes", "attempts"])


def _rates(scene: str, noise: str, rows: pd.DataFrame) -> Clearing:
    rounds = rows.assign(tried=rows["outcome"] != Outcome.NO_GRASP).groupby("round")
    counts = rounds.agg({"success": "sum", "tried": "sum", "n_objects": "first"})
    successes, tried, present = counts.to_numpy(dtype=np.int64).T
    return Clearing(
        scene, noise, len(counts), mean_of(successes, tried), mean_of(successes, present)
    )
