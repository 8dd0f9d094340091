"""Check that the simulation reproduces a table of attempts, given what the detector proposed."""

import hashlib
from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd

from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench.attempts import read_attempt, run_attempts
from egad.bench.parameters import ClutterParameters, TrialParameters
from egad.bench.rounds import Models, Round, repeat_round, round_name, rounds_of
from egad.detectors import Grasp, View
from egad.errors import UserError
from egad.grippers import Gripper
from egad.random import generator
from egad.sim import Model, UnstableError
from egad.tables import parquet
from egad.tables.clutter import ROUND
from egad.tables.outcomes import DETECTOR_FAILURES, SIMULATION_FAILURES, Outcome

UNSEEN = ("failure", "quality", "score")  # columns that only the detector determines
PLAN_COLUMNS = ["objects", "factors", "seed"]


class Difference(NamedTuple):
    """A value of a table that the simulation does not reproduce: `said` is that of the table."""

    place: str
    column: str
    said: object
    found: object


class _Recorded:
    """A detector that returns the proposals in a table, attempt by attempt."""

    def __init__(self, grasps: Sequence[Grasp | None]) -> None:
        self._grasps = iter(grasps)

    def __call__(self, _view: View, _gripper: Gripper, _rng: np.random.Generator) -> list[Grasp]:
        grasp = next(self._grasps, None)
        return [] if grasp is None else [grasp]


def verify_attempts(
    model: Model, rows: pd.DataFrame, settings: TrialParameters, tolerance: float = 0.0
) -> list[Difference]:
    """Run all attempts of `TRIALS` at an object again; numbers may differ by `tolerance`."""
    rows = rows.reset_index(drop=True)
    given = {"attempts": len(rows), "engine": rows["engine"].iloc[0]}
    settings = settings.model_copy(update={"trials": settings.trials.model_copy(update=given)})
    errors = settings.trials.errors
    known = [read_attempt(row, errors)[1] for row in parquet.records(rows) if row["initial_pose"]]
    label, name = rows["label"].iloc[0], rows["id"].iloc[0]
    again = run_attempts(model, label, name, _Recorded(known), settings)
    nothing = rows["width"].isna() & rows["outcome"].isin(DETECTOR_FAILURES)
    again["outcome"] = again["outcome"].mask(
        nothing & (again["outcome"] == Outcome.NO_GRASP), rows["outcome"]
    )
    places = [f"{label}, attempt {number}" for number in rows["attempt"]]
    return _differences(rows, again, places, tolerance)


def verify_rounds(
    table: pd.DataFrame, models: Models, settings: ClutterParameters, tolerance: float = 0.0
) -> list[Difference]:
    """Clear tables, whole rounds of `CLUTTER`, again; numbers may differ by `tolerance`."""
    engine = {"engine": table["engine"].iloc[0]}
    settings = settings.model_copy(update={"clutter": settings.clutter.model_copy(update=engine)})
    planned: dict[object, Round] = {each[:3]: each for each in rounds_of(list(models), settings)}
    found: list[Difference] = []
    for (scene, noise, number), group in table.groupby(ROUND, sort=False):
        rows = group.reset_index(drop=True)
        place, first = round_name(scene, noise, number), rows.iloc[0]
        noted, wanted = tuple(first[PLAN_COLUMNS]), None
        if plan := planned.get((scene, noise, number)):
            factors = " ".join(map(repr, plan.factors))
            wanted = (" ".join(plan.ids), factors, f"{plan.seed:032x}")
        if noted != wanted:
            found.append(Difference(place, ", ".join(PLAN_COLUMNS), noted, wanted))
        elif first["outcome"] != Outcome.CRASHED:
            found += _of_round(rows, place, models, settings, tolerance)
    return found


def _of_round(
    rows: pd.DataFrame, place: str, models: Models, settings: ClutterParameters, tolerance: float
) -> list[Difference]:
    """Differences in the rows of one round."""
    try:
        again = repeat_round(rows, models, settings)
    except UnstableError:  # it did not begin
        said = rows["outcome"].iloc[0]
        return [] if said == Outcome.FAILED else [Difference(place, "outcome", said, "failed")]
    if len(again) != len(rows):
        return [Difference(place, "number of attempts", len(rows), len(again))]
    places = [f"{place}, attempt {each}" for each in rows["attempt"]]
    return _differences(rows, again, places, tolerance)


def _differences(
    said: pd.DataFrame, found: pd.DataFrame, places: Sequence[str], tolerance: float
) -> list[Difference]:
    """Differences between two tables of the same rows, row by row."""
    differences = []
    for column in (each for each in said.columns if each not in UNSEEN):
        first, second = said[column].to_numpy(), found[column].to_numpy()
        if said[column].dtype.kind == "f":
            close = np.isclose(first, second.astype(np.float64), 0.0, tolerance, equal_nan=True)
        else:
            close = first == second
        differences += [
            (row, Difference(places[row], column, first[row], second[row]))
            for row in np.flatnonzero(~close).tolist()
        ]
    return [each for _, each in sorted(differences, key=lambda pair: pair[0])]


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
    tolerance: float = 0.0,
    jobs: int = 1,
) -> list[Difference]:
    """Simulate attempts again, without their detector: the differences beyond a tolerance."""
    check = partial(_check, models=models, settings=settings, tolerance=tolerance)
    with workers(jobs) as mapper:
        found = mapper(check, groups)
        return [each for some in progress(found, "simulating", len(groups)) for each in some]


def _check(
    rows: pd.DataFrame,
    models: Models,
    settings: TrialParameters | ClutterParameters,
    tolerance: float,
) -> list[Difference]:
    if isinstance(settings, ClutterParameters):
        return verify_rounds(rows, models, settings, tolerance)
    if rows["outcome"].isin(SIMULATION_FAILURES).all():
        return []
    name = str(rows["id"].iloc[0])
    if name not in models:
        raise UserError(f"no object {rows['label'].iloc[0]} ({name}) in this dataset")
    return verify_attempts(models[name], rows, settings, tolerance)


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
    found = {str(name): own.tolist() for name, own in rows["attempt"].groupby(keys)}
    yield from (f"{name} is not part of the protocol" for name in found if name not in counts)
    for name, count in counts.items():
        attempts = found.get(name, [])
        if not attempts or attempts != list(range(count or len(attempts))):
            yield f"{name}: attempts are missing, duplicated or out of order"


def _object_name(label: str, name: str) -> str:
    return f"{label} ({name})"
