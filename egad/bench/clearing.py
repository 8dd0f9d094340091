"""Preparation of objects and detectors for clearing tables, and the rounds themselves."""

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import NamedTuple, TypeAlias

import pandas as pd

from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench.parameters import ClutterParameters
from egad.bench.rounds import Round, run_round
from egad.bench.runner import Propose, proposed_by, timed
from egad.bench.scene_labels import SceneLabels
from egad.detectors import (
    Detect,
    DetectorConfig,
    FailureMonitor,
    check_gripper,
    grasps_if_any,
    knows_scene,
    opened,
)
from egad.errors import RejectedError, UserError
from egad.grasps import GraspLabel, label_parameters
from egad.grippers import Gripper
from egad.objects import NamedMesh
from egad.sim import Model
from egad.sim.model import simulated
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty

log = logging.getLogger(__name__)

Cleared: TypeAlias = tuple[pd.DataFrame, list[float]]  # attempts; planning times in seconds


class SceneObject(NamedTuple):
    """An object as it is simulated, and its labelled grasps, none if they are not needed."""

    id: str
    model: Model
    grasps: pd.DataFrame


def check_detector(detect: Detect, settings: ClutterParameters) -> None:
    """Start a detector and stop it again, before objects are prepared, which takes minutes.

    Raises:
        UserError: The detector cannot be found, made or started, or is for another kind of gripper.
    """
    with _proposer(detect, lambda _: empty(GRASPS), settings):
        pass


def prepare_objects(
    targets: Sequence[NamedMesh],
    gripper: Gripper,
    rule: str,
    label_seed: int | None = None,
    jobs: int = 1,
) -> list[SceneObject]:
    """Prepare objects for clearing tables; objects that cannot be simulated are left out.

    They have labelled grasps if there is a seed for them.

    Raises:
        UserError: None of the objects can be simulated.
    """
    work = partial(_prepared, rule=rule, gripper=gripper, label_seed=label_seed)
    with workers(jobs) as mapper:
        made = list(progress(mapper(work, targets), "making models", len(targets)))
    usable = [each for each in made if each is not None]
    if not usable:
        raise UserError("none of the objects can be simulated")
    return usable


def _prepared(
    target: NamedMesh, rule: str, gripper: Gripper, label_seed: int | None
) -> SceneObject | None:
    """An object as it is simulated; None if that is impossible."""
    try:
        mesh, model = simulated(target, gripper, rule)
    except RejectedError as reason:
        log.warning("%s is left out: %s", target.label, reason)
        return None
    if label_seed is None:
        return SceneObject(target.id, model, empty(GRASPS))
    wanted = label_parameters(gripper, GraspLabel().grasps, label_seed)
    return SceneObject(target.id, model, grasps_if_any(mesh, target.id, wanted))


def clear_rounds(
    rounds: Sequence[Round],
    objects: Sequence[SceneObject],
    detect: Detect,
    settings: ClutterParameters,
) -> Cleared:
    """The attempts of some rounds, and the planning times."""
    models = {each.id: each.model for each in objects}
    grasps = {each.id: each.grasps for each in objects}
    with open_table(detect, models.__getitem__, grasps.__getitem__, settings) as clear:
        # These may be only a few of the rounds; only the caller sees whether all of them fail.
        count, keep_going = len(rounds) + 1, settings.clutter.keep_going
        done, monitor = [], FailureMonitor(count, keep_going, "rounds", quiet=True)
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
    """A function that lets a detector clear one table, valid within the context.

    Models and labelled grasps (columns of `tables.grasping.GRASPS`) are looked up by the id of an
    object, grasps for `labels` only. UserError if the detector cannot be found or made.
    """
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
        with opened(detect, settings.clutter.planning_time) as found:
            yield lambda *_: proposed_by(found, settings.gripper, protocol)
