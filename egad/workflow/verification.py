"""Check whether tables of simulated attempts can be reproduced."""

import hashlib
from collections.abc import Iterator, Sequence
from functools import partial

import pandas as pd

from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench import (
    ClutterParameters,
    Difference,
    Models,
    TrialParameters,
    round_name,
    rounds_of,
    verify_attempts,
    verify_rounds,
)
from egad.config import Settings
from egad.config.stages import select
from egad.errors import UserError
from egad.random import generator
from egad.tables.clutter import ROUND
from egad.tables.outcomes import SIMULATION_FAILURES, Outcome


def groups_of(rows: pd.DataFrame, sample: int | None, seed: int) -> list[pd.DataFrame]:
    """The attempts of each object, or of each round of clearing a table.

    A sample of these groups is random. The seed determines it together with the table, so that
    nobody can know it in advance.
    """
    keys = ROUND if "scene" in rows else ["id"]
    groups = [own for _, own in rows.groupby(keys, sort=False)]
    if sample is None or sample >= len(groups):
        return groups
    digest = hashlib.sha256(
        pd.util.hash_pandas_object(rows, index=False).to_numpy().tobytes()
    ).hexdigest()
    chosen = generator(seed, "verify", digest).choice(len(groups), sample, replace=False)
    return [groups[number] for number in sorted(chosen)]


def verify_groups(
    groups: Sequence[pd.DataFrame],
    models: Models,
    settings: Settings,
    gripper: str,
    tolerance: float = 0.0,
    jobs: int = 1,
) -> list[Difference]:
    """Simulate attempts again, without their detector: the differences beyond a tolerance.

    The tolerance is 0 on the same kind of processor. Raises `UserError` if there is no object of a
    name.
    """
    is_clutter = any("scene" in rows for rows in groups)
    check = (
        partial(verify_rounds, models=models, settings=select(settings, ClutterParameters, gripper))
        if is_clutter
        else partial(_attempts, models=models, settings=select(settings, TrialParameters, gripper))
    )
    with workers(jobs) as mapper:
        found = mapper(partial(check, tolerance=tolerance), groups)
        return [each for some in progress(found, "simulating", len(groups)) for each in some]


def _attempts(
    rows: pd.DataFrame, models: Models, settings: TrialParameters, tolerance: float
) -> list[Difference]:
    if rows["outcome"].isin(SIMULATION_FAILURES).all():
        return []
    name = str(rows["id"].iloc[0])
    if name not in models:
        raise UserError(f"no object {rows['label'].iloc[0]} ({name}) in this dataset")
    return verify_attempts(models[name], rows, settings, tolerance)


def gaps(
    rows: pd.DataFrame, objects: pd.DataFrame, settings: Settings, gripper: str
) -> Iterator[str]:
    """Missing or surplus rows of a table: leaving out failures would improve the success rate.

    There is a sentence for each object (label and id), or round, that is not there as planned.
    """
    counts: dict[str, int | None]
    if "scene" in rows:
        planned = rounds_of(list(objects["id"]), select(settings, ClutterParameters, gripper))
        counts = {round_name(*each[:3]): None for each in planned}
        keys = [round_name(*each) for each in rows[ROUND].itertuples(index=False)]
        crashed = pd.Series(keys, rows.index)[rows["outcome"] == Outcome.CRASHED].unique()
        yield from (f"{name} crashed and cannot be verified" for name in crashed)
    else:
        names = map(_object_name, objects["label"], objects["id"])
        counts = dict.fromkeys(names, settings.trials.attempts)
        keys = list(map(_object_name, rows["label"], rows["id"]))
    found = {str(name): own.tolist() for name, own in rows["attempt"].groupby(keys)}
    yield from (f"{name} is not part of the protocol" for name in found if name not in counts)
    for name, count in counts.items():
        attempts = found.get(name, [])
        if not attempts or attempts != list(range(count or len(attempts))):
            yield f"{name}: attempts are missing, duplicated or out of order"


def _object_name(label: str, name: str) -> str:
    return f"{label} ({name})"
