"""What simulated labels of grasps say of their objects."""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.outcomes import Outcome

SHAKEN_AND_HELD = tuple(
    outcome.value for outcome in (Outcome.SUCCESS, Outcome.SLIPPED_LIFTING, Outcome.DROPPED)
)
"""Outcomes of grasps that held while the object was shaken."""


def with_outcome(grasps: pd.DataFrame) -> pd.DataFrame:
    """The grasps of which it is known whether they succeed.

    They are those that were simulated, and those at which the open hand collides.

    Args:
        grasps: Columns `simulated_success` and `collision_free`.
    """
    return grasps[grasps["simulated_success"].notna() | ~grasps["collision_free"]]


def held_when_shaken(grasps: pd.DataFrame) -> NDArray[np.bool_]:
    """Whether both fingers still held the object after it was shaken in simulation, (n,)."""
    return grasps["simulated_outcome"].isin(SHAKEN_AND_HELD).to_numpy(dtype=bool)


def simulated_graspability(grasps: pd.DataFrame) -> pd.DataFrame:
    """How often the simulated grasps of each object held (ours).

    Args:
        grasps: Columns of `tables.grasping.SIMULATED_GRASPS`; those that were not simulated, or
            with which the engine failed, do not count.

    Returns:
        One row per object that has any, sorted by label: `id`, `label`, `n_simulated`;
        `simulated_graspability`, the share that was shaken and lifted and still held, high for easy
        objects as graspability is; `held_shaking`, the share that held while it was shaken,
        which is ACRONYM's success; `simulated_engine`.
    """
    known = grasps[grasps["simulated_success"].notna()]
    marked = known.assign(
        success=known["simulated_success"].astype(float),
        shaken=known["simulated_outcome"].isin(SHAKEN_AND_HELD),
    )
    found = marked.groupby(["label", "id"], as_index=False).agg(
        n_simulated=("success", "size"),
        simulated_graspability=("success", "mean"),
        held_shaking=("shaken", "mean"),
        simulated_engine=("simulated_engine", "first"),
    )
    return found.sort_values("label", ignore_index=True)
