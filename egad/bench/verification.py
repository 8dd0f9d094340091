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
from egad.bench.reproduction import (
    Difference,
    Reproduction,
    differing,
    first_departure,
    judge,
    nudged,
)
from egad.bench.rounds import (
    Models,
    Round,
    failed_round,
    read_grasp,
    repeat_round,
    round_name,
    rounds_of,
)
from egad.bench.verified_attempts import verify_attempts
from egad.errors import UserError
from egad.random import generator
from egad.sim import UnstableError, check_engine, platform_of
from egad.tables import parquet
from egad.tables.clutter import ROUND
from egad.tables.columns import INITIAL
from egad.tables.outcomes import POSE_FAILURES, SIMULATION_FAILURES, Outcome

DETERMINED = ["seed", "objects", "factors", "engine", "protocol", "errors"]  # before a round
UNIT = 1e-6  # by how much the length of a quaternion may differ from 1


def verify_round(rows: pd.DataFrame, models: Models, settings: ClutterParameters) -> Reproduction:
    """Clear a table, a whole round of `CLUTTER`, again, and tell altered attempts from rounding."""
    rows = rows.reset_index(drop=True)
    engine = {"engine": rows["engine"].iloc[0]}
    settings = settings.model_copy(update={"clutter": settings.clutter.model_copy(update=engine)})
    key = tuple(rows[ROUND].iloc[0])
    places = [f"{round_name(*key)}, attempt {number}" for number in rows["attempt"]]
    planned = next((each for each in rounds_of(list(models), settings) if each[:3] == key), None)
    if planned is None:
        absent = Difference(places[0], "round", key[2], "not in the protocol")
        return Reproduction(len(rows), impossible=(absent,))
    if impossible := tuple(_contradictions(rows, planned, settings, places)):
        return Reproduction(len(rows), impossible=impossible)
    if rows["outcome"].iloc[0] == Outcome.CRASHED:
        return Reproduction()

    def simulate_nudged(fraction: float, numbers: Ints) -> pd.DataFrame:
        objects = {name: nudged(models[name], fraction) for name in planned.ids}
        try:
            return repeat_round(rows, objects, settings).reindex(numbers)
        except UnstableError:  # it did not begin
            return failed_round(planned, settings, Outcome.FAILED).reindex(numbers)

    return judge_round(rows, simulate_nudged, places)


def _contradictions(
    rows: pd.DataFrame, planned: Round, settings: ClutterParameters, places: list[str]
) -> Iterator[Difference]:
    """Values that the plan of a round rules out, and grasps that no hand would try."""
    determined = failed_round(planned, settings, Outcome.FAILED)[DETERMINED]
    yield from differing(rows, determined.iloc[[0] * len(rows)], places)
    for place, row in zip(places, parquet.records(rows), strict=True):
        grasp, outcome = read_grasp(row), row["outcome"]
        if isinstance(grasp, Outcome):
            if outcome not in (POSE_FAILURES if row["n_objects"] else SIMULATION_FAILURES):
                yield Difference(place, "outcome", outcome, "no grasp was tried")
        elif (flaw := grasp.infeasibility(settings.gripper)) or outcome in POSE_FAILURES:
            yield Difference(place, "outcome", outcome, flaw or "a grasp was tried")


def judge_round(
    said: pd.DataFrame,
    simulate_nudged: Callable[[float, Ints], pd.DataFrame],
    places: list[str],
) -> Reproduction:
    """Compare attempts up to the first that ended otherwise: the next ones began otherwise."""
    simulated = simulate_nudged(0.0, np.arange(len(said) + 1)).dropna(subset=["outcome"])
    common = min(len(said), len(simulated))
    departure = first_departure(said[:common], simulated[:common])
    if departure is not None:
        common = departure + 1
    judged = judge(said[:common], simulated[:common], places, simulate_nudged)
    if departure is None and len(said) != len(simulated):
        length = Difference(places[-1], "number of attempts", len(said), len(simulated))
        return judged + Reproduction(impossible=(length,))
    return judged + Reproduction(skipped=len(said) - common)


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
    for rows in groups:
        _check_values(rows)
    check = partial(_verify, models=models, settings=settings)
    with workers(jobs) as mapper:
        verdicts = mapper(check, groups)
        return sum(progress(verdicts, "simulating", len(groups)), start=Reproduction())


def _verify(
    rows: pd.DataFrame, models: Models, settings: TrialParameters | ClutterParameters
) -> Reproduction:
    if isinstance(settings, ClutterParameters):
        return verify_round(rows, models, settings)
    if rows["outcome"].isin(SIMULATION_FAILURES).all():
        return Reproduction(len(rows), same=len(rows))
    name = str(rows["id"].iloc[0])
    if name not in models:
        raise UserError(f"no object {rows['label'].iloc[0]} ({name}) in this dataset")
    return verify_attempts(models[name], rows, settings)


def _check_values(rows: pd.DataFrame) -> None:
    """Raise `UserError` for values that no attempt can have."""
    for engine in rows["engine"].unique():
        check_engine(engine)
    unknown = rows[~rows["outcome"].isin(list(Outcome))]
    missing = rows[rows[["seed", "platform"]].isna().any(axis=1)]
    broken = rows[:0]
    if "initial_pose" in rows:
        length = np.linalg.norm(rows[list(INITIAL[3:])].to_numpy(np.float64), axis=1)
        finite = np.isfinite(rows[list(INITIAL)].to_numpy(np.float64)).all(axis=1)
        broken = rows[(rows["initial_pose"] != "") & ~(finite & (abs(length - 1) < UNIT))]
    for some, sentence in (
        (unknown, "its outcome is unknown"),
        (missing, "it has no seed or no platform"),
        (broken, "its initial pose is not finite, or no rotation"),
    ):
        if len(some):
            row = some.iloc[0]
            place = row["label"] if "label" in rows else round_name(*row[ROUND])
            raise UserError(f"{place}, attempt {row['attempt']}: {sentence}")


def refusal(reproduction: Reproduction, rows: pd.DataFrame) -> list[str]:
    """Why a table is refused; nothing if it is honest."""
    reasons = reproduction.reasons()
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
