"""Where elites come from: their ancestors back to the random founders, even those long replaced."""

from collections.abc import Iterable

import pandas as pd

from egad.errors import UserError


def ancestors(elites: Iterable[str], lineage: pd.DataFrame) -> pd.DataFrame:
    """Elites and all their ancestors.

    An object that was taken in more than once, or by several islands, counts as of the first time:
    so every parent is older than its children. An archive may name other parents of it.

    Args:
        elites: Ids of the elites.
        lineage: All objects that the archives of a run took in, with the columns of
            `tables.evolution.LINEAGE`, in any order.

    Returns:
        The rows of these objects, in the order in which they were created.

    Raises:
        UserError: An elite or one of its ancestors is missing.
    """
    born = lineage.sort_values(["epoch", "step", "island", "id"]).drop_duplicates("id")
    parents = dict(zip(born["id"], born["parents"], strict=True))
    known: set[str] = set()
    waiting = list(elites)
    while waiting:
        name = waiting.pop()
        if name in known:
            continue
        if name not in parents:
            raise UserError(f"the object {name} is missing: an ancestry needs all epochs of a run")
        known.add(name)
        waiting.extend(parents[name])
    return born[born["id"].isin(known)].reset_index(drop=True)
