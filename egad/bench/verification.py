"""Check that the simulation reproduces a table of attempts, given what the detector proposed."""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np
import pandas as pd

from egad._util.arrays import Ints
from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench.parameters import ClutterParameters, TrialParameters
from egad.bench.reproduction import Difference, Reproduction, first_departure, judge, nudged
from egad.bench.rounds import Models, failed_round, repeat_round, round_name, rounds_of
from egad.bench.verified_attempts import verify_attempts
from egad.errors import UserError
from egad.random import generator
from egad.sim import UnstableError, platform_of
from egad.tables.clutter import ROUND
from egad.tables.outcomes import SIMULATION_FAILURES, Outcome

GIVEN = ["seed", "objects", "factors", "engine", "protocol", "errors"]  # known before a round


def verify_round(rows: pd.DataFrame, models: Models, settings: ClutterParameters) -> Reproduction:
    """Clear a table, a whole round of `CLUTTER`, again, and tell altered attempts from rounding."""
    rows = rows.reset_index(drop=True)
    engine = {"engine": rows["engine"].iloc[0]}
    settings = settings.model_copy(update={"clutter": settings.clutter.model_copy(update=engine)})
    key = tuple(rows[ROUND].iloc[0])
    places = [f"{round_name(*key)}, attempt {number}" for number in rows["attempt"]]
    planned = next((each for each in rounds_of(list(models), settings) if each[:3] == key), None)
    if planned is None:
        absent = Difference(places[0], "round", key, "not in the protocol")
        return Reproduction(len(rows), impossible=(absent,))
    given = failed_round(planned, settings, Outcome.FAILED).iloc[0]
    if impossible := tuple(
        Difference(places[number], column, rows[column][number], given[column])
        for column in GIVEN
        for number in np.flatnonzero(rows[column].to_numpy() != given[column])
    ):
        return Reproduction(len(rows), impossible=impossible)
    if rows["outcome"].iloc[0] == Outcome.CRASHED:
        return Reproduction()

    def again(by: float, numbers: Ints) -> pd.DataFrame:
        moved = {name: nudged(models[name], by) for name in planned.ids}
        try:
            return repeat_round(rows, moved, settings).reindex(numbers)
        except UnstableError:  # it did not begin
            return failed_round(planned, settings, Outcome.FAILED).reindex(numbers)

    return _judge_round(rows, again(0.0, np.arange(len(rows) + 1)), places, again)


def _judge_round(
    said: pd.DataFrame,
    found: pd.DataFrame,
    places: list[str],
    again: Callable[[float, Ints], pd.DataFrame],
) -> Reproduction:
    """Compare attempts up to the first that ended otherwise: the next ones began otherwise."""
    found = found.dropna(subset=["outcome"])
    common = min(len(said), len(found))
    departure = first_departure(said[:common], found[:common])
    if departure is not None:
        common = departure + 1
    verdict = judge(said[:common], found[:common], places, again)
    if departure is None and len(said) != len(found):
        length = Difference(places[-1], "number of attempts", len(said), len(found))
        return verdict + Reproduction(impossible=(length,))
    return verdict + Reproduction(unchecked=len(said) - common)


def groups_of(rows: pd.DataFrame, sample: int | None, seed: int) -> list[pd.DataFrame]:
    """The attempts of each object or round; a sample follows from the seed and the table."""
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
    settings: TrialParameters | ClutterParameters,
    jobs: int = 1,
) -> Reproduction:
    """Simulate attempts again, without their detector, and say whether the table is honest."""
    check = partial(_check, models=models, settings=settings)
    with workers(jobs) as mapper:
        verdicts = mapper(check, groups)
        return sum(progress(verdicts, "simulating", len(groups)), start=Reproduction())


def _check(
    rows: pd.DataFrame, models: Models, settings: TrialParameters | ClutterParameters
) -> Reproduction:
    if isinstance(settings, ClutterParameters):
        return verify_round(rows, models, settings)
    if rows["outcome"].isin(SIMULATION_FAILURES).all():
        return Reproduction()
    name = str(rows["id"].iloc[0])
    if name not in models:
        raise UserError(f"no object {rows['label'].iloc[0]} ({name}) in this dataset")
    return verify_attempts(models[name], rows, settings)


def refusal(verdict: Reproduction, rows: pd.DataFrame) -> list[str]:
    """Why a table is refused; nothing if it is honest."""
    reasons = verdict.reasons()
    here = platform_of(rows["engine"].iloc[0])
    others = sorted(set(rows["platform"]) - {here})
    if reasons and others:
        reasons.append(f"it was made with {others[0]}, and simulated here with {here}")
    return reasons


def gaps(
    rows: pd.DataFrame, objects: pd.DataFrame, settings: TrialParameters | ClutterParameters
) -> Iterator[str]:
    """Sentences on missing or surplus rows, by object or round: leaving out failures pays."""
    counts: dict[str, int | None]
    if isinstance(settings, ClutterParameters):
        planned = rounds_of(list(objects["id"]), settings)
        counts = {round_name(*each[:3]): None for each in planned}
        keys = [round_name(*each) for each in rows[ROUND].itertuples(index=False)]
        crashed = pd.Series(keys, rows.index)[rows["outcome"] == Outcome.CRASHED].unique()
        yield from (f"{name} crashed and cannot be verified" for name in crashed)
    else:
        names = map(_object_name, objects["label"], objects["id"])
        counts = dict.fromkeys(names, settings.trials.attempts)
        keys = list(map(_object_name, rows["label"], rows["id"]))
    found = {
        str(name): own.tolist()
        for name, own in rows["attempt"].groupby(pd.Series(keys, rows.index))
    }
    yield from (f"{name} is not part of the protocol" for name in found if name not in counts)
    for name, count in counts.items():
        attempts = found.get(name, [])
        if not attempts or attempts != list(range(count or len(attempts))):
            yield f"{name}: attempts are missing, duplicated or out of order"


def _object_name(label: str, name: str) -> str:
    return f"{label} ({name})"
