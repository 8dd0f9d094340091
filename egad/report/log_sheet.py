"""A page to log grasp attempts with a real robot, which needs no network and no other file.

`egad.bench.stats.read` reads the CSV file that it exports; `LOG_COLUMNS` there are its columns.
"""

import base64
import hashlib
import json
import string
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from egad.bench.stats import LOG_COLUMNS, LOG_SCHEMA
from egad.errors import UserError
from egad.random import generator
from egad.report.page import render_template
from egad.tables.outcomes import DETECTOR_FAILURES, OBSERVABLE, Outcome

PURPOSE = "log sheet"  # of the random numbers
MAX_DETECTORS = len(string.ascii_uppercase)
MAX_NAME = 60
REASONS = (
    "wrong object, pose or detector",
    "operator or robot stopped it for a reason other than the grasp",
    "camera or network failed",
    "object or gripper was damaged",
)
FIELDS = {  # of a session: key, name, and an example
    "operator": ("Operator", "your name or initials"),
    "robot": ("Robot", "Franka Panda"),
    "gripper": ("Gripper", "Franka Hand"),
    "pads": ("Pads", "silicone, new in May"),
    "camera": ("Camera", "RealSense D435 on the wrist"),
    "calibration": ("Calibration", "2026-05-02, 1.8 mm"),
    "prints": ("Prints", "PLA, matt; scaled to 75 mm"),
}
REQUIRED = ("operator", "robot", "gripper")


class PlannedAttempt(NamedTuple):
    """A planned attempt."""

    label: str
    attempt: int
    detector: str


@dataclass(frozen=True)
class LogObject:
    """An object to try: label in the evaluation set, such as C4; id in the dataset; PNG file."""

    label: str
    id: str
    picture: bytes


@dataclass(frozen=True)
class LogPlan:
    """What a session consists of."""

    attempts: int  # attempts by each detector at each object
    seed: int
    order: tuple[PlannedAttempt, ...]
    # name of each detector on the page: its own, or a letter if the session is blinded
    shown: dict[str, str]
    blind: bool  # whether the operator does not know the detectors


def attempt_order(
    labels: Iterable[str],
    attempts: int,
    detectors: Iterable[str],
    seed: int,
    *,
    rounds: bool = False,
) -> list[PlannedAttempt]:
    """The order of all attempts by each detector at each object, from a seed alone.

    Objects come in random order; detectors alternate at random, so that worn pads affect all
    equally. In rounds, every object comes once before any again, as tests on the way need.
    """
    names, objects = sorted(detectors), sorted(labels)
    if rounds:
        return [
            PlannedAttempt(label, attempt, detector)
            for attempt in range(attempts)
            for label in _shuffled(objects, seed, "objects", "round", attempt)
            for detector in _shuffled(names, seed, "detectors", label, attempt)
        ]
    return [
        PlannedAttempt(label, attempt, detector)
        for label in _shuffled(objects, seed, "objects")
        for attempt in range(attempts)
        for detector in _shuffled(names, seed, "detectors", label, attempt)
    ]


def plan(
    labels: Iterable[str],
    attempts: int,
    detectors: Sequence[str],
    seed: int,
    *,
    blind: bool,
    rounds: bool = False,
) -> LogPlan:
    """Plan a session as in `attempt_order`; blind: detectors are A, B, ... in random order."""
    _check_detectors(detectors)
    if attempts < 1:
        raise UserError(f"--attempts {attempts} is not allowed; allowed: 1 or more")
    order = attempt_order(labels, attempts, detectors, seed, rounds=rounds)
    names = _shuffled(sorted(detectors), seed, "letters") if blind else list(detectors)
    letters = string.ascii_uppercase if blind else names
    shown = dict(zip(names, letters, strict=False))
    return LogPlan(attempts, seed, tuple(order), shown, blind)


def order_table(planned: LogPlan, objects: Iterable[LogObject]) -> pd.DataFrame:
    """The order for a robot program, with true names of detectors, and empty cells for results."""
    ids = {item.label: item.id for item in objects}
    table = pd.DataFrame(planned.order, columns=list(PlannedAttempt._fields))
    table.insert(0, "order", range(1, len(table) + 1))
    table.insert(2, "id", table["label"].map(ids))
    return table.assign(success="", outcome="", note="")


def page(
    planned: LogPlan,
    objects: Sequence[LogObject],
    title: str,
    outcomes: Sequence[Outcome] = OBSERVABLE,
) -> str:
    """The HTML page of a plan, titled by its objects, that offers these outcomes."""
    labels = [item.label for item in objects]
    names = list(planned.shown)
    agreed = {
        "seed": planned.seed,
        "blind": planned.blind,
        "detectors": [{"name": name, "shown": shown} for name, shown in planned.shown.items()],
        "objects": [{"label": item.label, "id": item.id} for item in objects],
        "order": [
            [labels.index(each.label), each.attempt, names.index(each.detector)]
            for each in planned.order
        ],
    }
    data = {
        **agreed,
        "schema": LOG_SCHEMA,
        "sheet": hashlib.sha256(json.dumps(agreed).encode()).hexdigest()[:12],
        "attempts": planned.attempts,
        "columns": LOG_COLUMNS,
        "outcomes": outcomes,
        "fields": list(FIELDS),
    }
    return render_template(
        "log_sheet.html.j2",
        data=data,
        pictures=[base64.b64encode(item.picture).decode() for item in objects],
        planned=planned,
        title=title,
        outcomes=[_outcome(each) for each in outcomes],
        reasons=REASONS,
        fields=FIELDS,
        required=REQUIRED,
    )


def _outcome(outcome: Outcome) -> dict[str, Any]:
    return {
        "code": outcome.value,
        "name": outcome.value.replace("_", " "),
        "meaning": outcome.meaning,
        "of_detector": outcome in DETECTOR_FAILURES,
    }


def _shuffled(names: Sequence[str], seed: int, *index: int | str) -> list[str]:
    order = generator(seed, PURPOSE, *index).permutation(len(names))
    return [names[place] for place in np.asarray(order)]


def _check_detectors(names: Sequence[str]) -> None:
    """Check that names of detectors can be used in the order and in a CSV file."""
    for name in names:
        if not name[:1].isalnum() or len(name) > MAX_NAME or not name.isprintable():
            raise UserError(
                f"--detectors: {name!r} cannot be the name of a detector; allowed: a letter or "
                f"digit, then up to {MAX_NAME - 1} characters without commas"
            )
        if names.count(name) > 1:
            raise UserError(f"--detectors: {name} is named twice")
    if not 1 <= len(names) <= MAX_DETECTORS:
        raise UserError(f"--detectors: {len(names)} names; allowed: 1 to {MAX_DETECTORS}")
