"""The tables of README.md: what the errors of a real cell cost.

`cell_errors.py FOLDER [NAME=WEIGHTS ...]` tries detectors on the evaluation set of the release with
the gripper `egad_75mm`. The first table has both meanings of a contact on the way down, without
errors and with `typical` ones; the second has the cost of each of these errors alone, with a hand
that closes where it is stopped, compared object by object. `NAME=WEIGHTS` adds GG-CNN with other
weights, with grasps as deep as the image allows and as published. Tables of attempts are kept in
FOLDER: use another one for each `--noise`. A second call runs what is missing.
"""

import argparse
import itertools
import pickle
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

import egad
from egad._util.files import atomic_output
from egad._util.workers import workers
from egad.bench import NAMED_ERRORS, TrialParameters, TrialProtocol, run_attempts
from egad.bench.stats import Interval, compare, mean_rate, results
from egad.bench.trials import SAMPLED
from egad.detectors import DETECTORS, GGCNN, Detector, Labels, make_detector
from egad.grasps import label_parameters
from egad.grasps.sampling import dataset_grasps
from egad.grippers import GRIPPERS
from egad.objects import NamedMesh, named_meshes
from egad.sim import ENGINES, EngineName, Model
from egad.sim.model import simulated

HAND = GRIPPERS["egad_75mm"]
TYPICAL = NAMED_ERRORS["typical"]
ALONE: dict[str, Any] = {
    "calibration": TYPICAL.model_dump(include={"calibration", "calibration_turn"}),
    **{
        name: TYPICAL.model_dump(include={name})
        for name in ("positioning", "friction", "mass", "opening", "stopping_force")
    },
}
ERRORS: dict[str, Any] = {"none": "none", **ALONE, "typical": "typical"}
CONTACTS = {"collided": 20.0, "close": 10.0}  # newtons that stop the hand
NAMES = ("labels", "antipodal-depth", "ggcnn2-evolved", "ggcnn2-evolved-published", "random")


class Prepared(NamedTuple):
    """An object of the evaluation set, scaled to the hand, with its labelled grasps."""

    label: str
    id: str
    model: Model
    labels: Labels


def prepare(target: NamedMesh) -> Prepared:
    """Scale an object, split it into convex parts, and label grasps of it."""
    mesh, model = simulated(target, HAND, "paper")
    grasps = dataset_grasps(mesh, target.id, label_parameters(HAND, SAMPLED, 0))
    return Prepared(target.label, target.id, model, Labels(grasps))


def prepared(path: Path, jobs: int) -> list[Prepared]:
    """All objects, made once."""
    if not path.exists():
        with workers(jobs) as mapper:
            found = list(mapper(prepare, named_meshes(egad.load("evaluation-set"))))
        with atomic_output(path) as out:
            out.write_bytes(pickle.dumps(found))
    return pickle.loads(path.read_bytes())  # type: ignore[no-any-return]  # noqa: S301 (this file is ours)


def tried(this: Prepared, detect: Detector | None, parameters: TrialParameters) -> pd.DataFrame:
    """All attempts of a detector at an object; without a detector, of the labelled grasps."""
    return run_attempts(this.model, this.label, this.id, detect or this.labels, parameters)


def main(
    folder: Path,
    detectors: dict[str, Detector | None],
    engine: EngineName,
    attempts: int,
    noise: float,
    jobs: int,
) -> None:
    """Run what is missing, and print both tables."""
    folder.mkdir(parents=True, exist_ok=True)
    objects = prepared(folder / "objects.pickle", jobs)

    def attempts_of(name: str, errors: str, contact: str) -> pd.DataFrame:
        path = folder / str(attempts) / engine / contact / errors / f"{name}.parquet"
        if not path.exists():
            protocol = {"errors": ERRORS[errors], "contact": contact, "engine": engine}
            trials = TrialProtocol(
                attempts=attempts, depth_noise=noise, stopping_force=CONTACTS[contact], **protocol
            )
            parameters = TrialParameters(seed=0, gripper=HAND, trials=trials)
            with workers(jobs) as mapper:
                work = partial(tried, detect=detectors[name], parameters=parameters)
                found = pd.concat(mapper(work, objects))
            path.parent.mkdir(parents=True, exist_ok=True)
            with atomic_output(path) as out:
                found.to_parquet(out)
        return pd.read_parquet(path)

    def rate(name: str, errors: str, contact: str) -> str:
        mean = mean_rate(attempts_of(name, errors, contact))
        return percent(mean.value, mean.interval)

    def row_of(name: str, letter: str) -> str:
        attempts = attempts_of(name, "typical", "collided")
        mean = mean_rate(attempts[attempts["label"].str.startswith(letter)])
        return percent(mean.value, mean.interval)

    def cost(name: str, errors: str) -> str:
        both = [results(attempts_of(name, each, "close"), name) for each in (errors, "none")]
        difference = compare(*both)
        return percent(difference.difference, difference.interval)

    both = list(itertools.product(CONTACTS, ("none", "typical")))
    table(
        detectors,
        [f"{error}, {contact}" for contact, error in both] + ["row A: typical, collided", "row G"],
        lambda name: (
            *(rate(name, error, contact) for contact, error in both),
            *(row_of(name, letter) for letter in "AG"),
        ),
    )
    alone = [error for error in ERRORS if error != "none"]
    table(NAMES, alone, lambda name: (cost(name, error) for error in alone))


def percent(value: float, interval: Interval) -> str:
    """A rate or difference with its interval, in percent."""
    rate, low, high = np.round(100 * np.array([value, *interval])) + 0.0  # no -0
    return f"{rate:.0f} ({low:.0f} to {high:.0f})"


def table(
    detectors: Iterable[str],
    columns: list[str],
    cells: Callable[[str], Iterable[str]],
) -> None:
    """Print a table row by row, one for each detector."""
    print(f"| detector | {' | '.join(columns)} |\n{'| --- ' * (1 + len(columns))}|")
    for name in detectors:
        print(f"| `{name}` | {' | '.join(cells(name))} |", flush=True)


def weights(given: list[str]) -> Iterator[tuple[str, Detector]]:
    """GG-CNN with other weights, with grasps as deep as the image allows and as published."""
    for each in given:
        name, _, path = each.partition("=")
        yield name, GGCNN(path)
        yield f"{name}-published", GGCNN(path, "published")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("weights", nargs="*")
    parser.add_argument("--engine", choices=ENGINES, default=ENGINES[0])
    parser.add_argument("--attempts", type=int, default=20)
    parser.add_argument("--noise", type=float, default=0.1, help="pixels of disparity")
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_intermixed_args()
    shipped = {name: None if name == "labels" else make_detector(DETECTORS[name]) for name in NAMES}
    detectors = shipped | dict(weights(chosen.weights))
    main(chosen.folder, detectors, chosen.engine, chosen.attempts, chosen.noise, chosen.jobs)
