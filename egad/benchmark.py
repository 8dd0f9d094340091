"""Clearing tables of objects with a grasp detector, from Python."""

import logging
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import pandas as pd
import trimesh

from egad._util.parameters import from_arguments
from egad._util.progress import progress
from egad._util.workers import workers
from egad.api import dataset_grasps
from egad.detectors import IN_SCENES, with_checked_answers
from egad.errors import RejectedError, UserError, check_name
from egad.evalset import Bundle
from egad.geometry import Material
from egad.grasps import GraspLabel, Gripper, as_gripper, label_parameters
from egad.objects import RULES, Dataset, NamedMesh, named_meshes, scaled_solid
from egad.perception import NOISES, NoiseName
from egad.sim import (
    SCENE_KINDS,
    Clutter,
    ClutterParameters,
    EngineChoice,
    Model,
    Propose,
    Round,
    SceneKind,
    SceneLabels,
    build,
    installed_engine,
    proposed_by,
    rounds_of,
    run_round,
)
from egad.stats import Clearing, clearing_rates
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty

log = logging.getLogger(__name__)

LABELS = "labels"
SHARDS = 4  # for each job, so that none waits long for the others
ROUND = ["scene", "noise", "round"]


class Benchmark:
    """Rounds of clearing a table.

    Attributes:
        table: One row per attempt; columns as in `results/README.md`, "clutter".
    """

    def __init__(self, table: pd.DataFrame) -> None:
        """Wrap a table with the columns of `tables.clutter.CLUTTER`."""
        self.table = table.reset_index(drop=True)

    def __repr__(self) -> str:
        return f"Benchmark({len(self.table)} attempts)"

    def rates(self) -> list[Clearing]:
        """Success rate and share of objects cleared for each kind of scene and noise."""
        return clearing_rates(self.table)


class _Object(NamedTuple):
    """An object as it is simulated, and its labelled grasps, none if they are not needed."""

    id: str
    model: Model
    grasps: pd.DataFrame


def run_benchmark(
    detect: Callable[..., Any] | str,
    objects: Dataset | Mapping[str, trimesh.Trimesh],
    gripper: Gripper | str = "panda",
    *,
    scenes: Sequence[SceneKind] = SCENE_KINDS,
    noise: Sequence[NoiseName] = NOISES[:2],
    rounds: int = 100,
    per_scene: int = 5,
    scale: tuple[float, float] = (0.8, 1.0),
    seed: int = 0,
    rule: str = "paper",
    engine: EngineChoice = "mujoco",
    jobs: int = 1,
) -> Benchmark:
    """Let a detector clear a table, as in the experiments of VGN (Breyer et al. 2020, section V).

    In each round some of the objects are put on the table: one alone, upright side by side, or in a
    pile. Six depth cameras look at them, the detector proposes grasps, and a hand without an arm
    carries out the best one. What is held is removed. The round ends when nothing is left, nothing
    is proposed, or two attempts in a row have failed.

    Args:
        detect: A function or object that is called with what it asks for, the gripper and a random
            generator (`egad.detectors.wanted_input`) and returns poses, widths and scores
            (`egad.detectors.GraspPoses`), or grasps from above; or the name of one without weights:
            `antipodal-cloud`, `antipodal-depth`, `random`; or `labels`, which knows where the
            objects are and proposes the best of 100 sampled grasps of each. With several jobs it
            must be importable.
        objects: A dataset, or meshes in metres by name.
        gripper: The gripper, or its name.
        scenes: Of single, packed, pile.
        noise: Of none, stereo, gamma.
        rounds: Of each kind of scene and noise.
        per_scene: Objects in packed and piled scenes.
        scale: Range of the sizes of the objects, of those by the rule.
        seed: The same seed gives the same scenes, for all detectors and kinds of noise.
        rule: How objects are scaled to the gripper: see `egad.rescale`; `none`: not.
        engine: What computes the physics: `mujoco`, `pybullet`; `auto`: PyBullet if installed.
        jobs: Processes; the result does not depend on them. With several, a script needs
            `if __name__ == "__main__":` around its call.

    Raises:
        UserError: There is no such gripper, detector, scene, noise or rule, the engine is not
            installed, a number is out of bounds, or there are no objects that can be simulated.

    Warns:
        UnitsWarning: The size of a mesh suggests another unit than the metre.
    """
    hand = as_gripper(gripper)
    check_name("rule", rule, RULES)
    clutter = from_arguments(
        Clutter,
        engine=installed_engine(engine),
        scenes=tuple(scenes),
        noise=tuple(noise),
        rounds=rounds,
        objects=per_scene,
        scale=scale,
    )
    settings = ClutterParameters(seed, hand, clutter)
    if isinstance(detect, str):
        check_name("detector", detect, (LABELS, *IN_SCENES))
    elif not callable(detect):
        raise UserError(f"a detector is a function or the name of one, got {detect!r}")
    label_seed = seed if detect == LABELS else None
    prepare = partial(_prepared, rule=rule, gripper=hand, label_seed=label_seed)
    targets = named_meshes(objects)
    with workers(jobs, chunk=1) as mapper:
        made = list(progress(mapper(prepare, targets), "making models", len(targets)))
        usable = [each for each in made if each is not None]
        if not usable:
            raise UserError("none of the objects can be simulated")
        todo = rounds_of([each.id for each in usable], settings)
        shards = [todo[first :: SHARDS * jobs] for first in range(min(SHARDS * jobs, len(todo)))]
        work = partial(_cleared, objects=usable, detect=detect, settings=settings)
        tables = list(progress(mapper(work, shards), "clearing", len(shards)))
    by_round = {key: rows for table in tables for key, rows in table.groupby(ROUND)}
    return Benchmark(pd.concat([by_round[this[:3]] for this in todo]))


def _prepared(
    target: NamedMesh, rule: str, gripper: Gripper, label_seed: int | None
) -> _Object | None:
    """An object as it is simulated; None if that is impossible.

    Args:
        target: The object.
        rule: How it is scaled.
        gripper: What it is scaled to.
        label_seed: For labelled grasps; None if they are not needed.
    """
    try:
        mesh = scaled_solid(target, gripper, rule)
        model = build(mesh, Material().density, Bundle())
        if label_seed is None:
            return _Object(target.id, model, empty(GRASPS))
        wanted = label_parameters(gripper, GraspLabel().grasps, label_seed)
        return _Object(target.id, model, dataset_grasps(mesh, target.id, wanted))
    except RejectedError as reason:
        log.warning("%s is left out: %s", target.label, reason)
        return None


def _cleared(
    rounds: Sequence[Round],
    objects: Sequence[_Object],
    detect: Callable[..., Any] | str,
    settings: ClutterParameters,
) -> pd.DataFrame:
    """The attempts of some rounds, columns of `tables.clutter.CLUTTER`."""
    models = {each.id: each.model for each in objects}
    grasps = {each.id: each.grasps for each in objects}

    def proposer(ids: Sequence[str], sized: Sequence[Model]) -> Propose:
        if detect == LABELS:
            return SceneLabels([grasps[name] for name in ids], sized, settings.gripper)
        known = IN_SCENES[detect] if isinstance(detect, str) else with_checked_answers(detect)
        return proposed_by(known, settings.gripper)

    return pd.concat([run_round(this, models, proposer, settings) for this in rounds])
