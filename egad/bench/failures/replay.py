"""Repeating attempts of a search from their rows alone, without the detector, and filming them."""

from collections import defaultdict
from collections.abc import Callable

import pandas as pd
import trimesh

from egad._util.arrays import RgbImage
from egad.bench.failures.models import ON_ROUGH, model_of_attempts
from egad.bench.failures.object_runner import ObjectRunner, open_runner
from egad.bench.failures.parameters import FailureParameters
from egad.bench.failures.reference import read_attempt
from egad.errors import UserError
from egad.sim import EngineName, Film
from egad.tables.grasping import GRASPS
from egad.tables.outcomes import Outcome
from egad.tables.parquet import empty, records


def repeat_attempts(
    mesh: trimesh.Trimesh,
    attempts: pd.DataFrame,
    settings: FailureParameters,
    watch: Callable[[int, ObjectRunner], object] = lambda *_: None,
) -> list[Outcome]:
    """Outcomes of attempts at an object, scaled mesh, executed again; `watch` precedes each."""
    if (attempts["pose"].map(len) == 0).any():
        raise UserError("there is no grasp to repeat: the detector proposed nothing")
    groups = defaultdict[tuple[str, EngineName], list[int]](list)
    for number, (purpose, engine) in enumerate(attempts[["purpose", "engine"]].to_numpy()):
        groups["screen" if purpose in ON_ROUGH else "confirm", engine].append(number)
    models = {
        purpose: model_of_attempts(mesh, purpose, settings)
        for purpose in dict.fromkeys(purpose for purpose, _ in groups)
    }
    outcomes, tried = {}, list(map(read_attempt, records(attempts)))
    for (purpose, engine), numbers in groups.items():
        from_above, model = settings.failures.approach == "above", models[purpose]
        with open_runner(engine, model, empty(GRASPS), settings, from_above=from_above) as runner:
            for number in numbers:
                watch(number, runner)
                outcomes[number] = runner.execute(*tried[number])
    return [outcomes[number] for number in range(len(attempts))]


def film_attempts(
    mesh: trimesh.Trimesh, attempts: pd.DataFrame, settings: FailureParameters
) -> list[list[RgbImage]]:
    """Frames, 20 per second, of attempts executed again; UserError if one ends differently."""
    films: dict[int, Film] = {}
    again = repeat_attempts(
        mesh, attempts, settings, lambda number, runner: films.update({number: Film(runner.world)})
    )
    for row, outcome in zip(attempts.to_dict("records"), again, strict=True):
        if row["outcome"] != outcome:
            raise UserError(
                f"{row['id']}, drop {row['drop']} in {row['engine']}: {row['outcome']} became "
                f"{outcome}; machine, settings or the version of the engine must differ"
            )
    return [films[number].frames for number in range(len(attempts))]
