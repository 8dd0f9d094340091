"""Preparation of objects and detectors for clearing tables, and the rounds themselves."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TypeAlias

import pandas as pd

from egad.bench.parameters import ClutterParameters
from egad.bench.preparation import SceneObject, models_of
from egad.bench.rounds import Round, run_round
from egad.bench.runner import Propose, proposed_by, timed
from egad.bench.scene_labels import SceneLabels
from egad.detectors import (
    Detect,
    DetectorConfig,
    FailureMonitor,
    check_gripper,
    knows_scene,
    opened,
)
from egad.sim import Model
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty

Cleared: TypeAlias = tuple[pd.DataFrame, list[float]]  # attempts; planning times in seconds


def check_detector(detect: Detect, settings: ClutterParameters) -> None:
    """Start and stop a detector, before objects take minutes; UserError as from `open_table`."""
    with _proposer(detect, lambda _: empty(GRASPS), settings):
        pass


def clear_rounds(
    rounds: Sequence[Round],
    objects: Mapping[str, SceneObject],
    detect: Detect,
    settings: ClutterParameters,
    keep_going: bool = False,
) -> Cleared:
    """The attempts of some rounds with objects by id, and the planning times."""
    models = models_of(objects)
    with open_table(
        detect, models.__getitem__, lambda name: objects[name].grasps, settings
    ) as clear:
        # These may be only a few of the rounds; only the caller sees whether all of them fail.
        done = []
        monitor = FailureMonitor(len(rounds) + 1, keep_going, "rounds", quiet=True)
        for this in rounds:
            done.append(clear(this))
            monitor.check(done[-1][0])
    return pd.concat([table for table, _ in done]), [time for _, times in done for time in times]


@contextmanager
def open_table(
    detect: Detect,
    model: Callable[[str], Model],
    grasps: Callable[[str], pd.DataFrame],
    settings: ClutterParameters,
) -> Iterator[Callable[[Round], Cleared]]:
    """A function that clears one table; models, and `GRASPS` for `labels`, are looked up by id."""
    with _proposer(detect, grasps, settings) as proposer:

        def clear(this: Round) -> Cleared:
            seconds: list[float] = []
            models = {name: model(name) for name in this.ids}
            table = run_round(
                this, models, lambda *scene: timed(proposer(*scene), seconds), settings
            )
            return table, seconds

        yield clear


@contextmanager
def _proposer(
    detect: Detect, grasps: Callable[[str], pd.DataFrame], settings: ClutterParameters
) -> Iterator[Callable[[Sequence[str], Sequence[Model]], Propose]]:
    """A function that maps the objects of a scene to a proposer of grasps."""
    protocol = settings.clutter.protocol
    if isinstance(detect, DetectorConfig):
        check_gripper(detect.name, settings.gripper)
        if detect.detector == "vgn" and detect.threshold is None:
            detect = detect.model_copy(update={"threshold": protocol.threshold})
    if knows_scene(detect):
        yield lambda ids, models: SceneLabels(list(map(grasps, ids)), models, settings.gripper)
    else:
        with opened(detect, settings.planning_time) as found:
            yield lambda *_: proposed_by(found, settings.gripper, protocol)
