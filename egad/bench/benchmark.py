"""Clearing tables of objects with a grasp detector, from Python."""

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import trimesh

from egad._util.display import table_html
from egad._util.files import as_path
from egad._util.parameters import from_arguments
from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench.clearing import Cleared, check_detector, clear_rounds
from egad.bench.parameters import CellErrors, Clutter, ClutterParameters, hand_of
from egad.bench.preparation import (
    SceneObject,
    labels_from,
    lazy_objects,
    models_of,
    prepare_objects,
)
from egad.bench.protocols import SCENE_KINDS, ClutterProtocol, SceneKind
from egad.bench.rounds import film_round, rounds_of
from egad.bench.stats import (
    Clearing,
    ClearingComparison,
    clearing_rates,
    compare_clearing,
    engine_names,
)
from egad.detectors import (
    IN_SCENES,
    LABELS,
    SHIPPED_NETWORKS,
    Detect,
    DetectorConfig,
    FailureMonitor,
    NoiseName,
    as_detector,
    knows_scene,
    wanted_input,
)
from egad.errors import UserError
from egad.grasps import Grasps
from egad.grippers import Gripper
from egad.io import check_ending
from egad.objects import EVALUATION_SET, Dataset, NamedMesh, load, named_meshes
from egad.sim import ENDINGS, EngineName, Model, write_film
from egad.tables.clutter import ROUND

SHARDS = 4  # per job, so that no job waits long for the others
FEWEST = 5  # rounds of a shard, if there are enough: each starts the detector again


class Scenes(NamedTuple):
    """The objects of some rounds, by id, and their settings."""

    models: Mapping[str, Model]
    settings: ClutterParameters


class Benchmark:
    """Rounds of clearing a table.

    Attributes:
        table: One row per attempt; columns as in `results/README.md`, "clutter".
        planning_time: Median time from the depth images to the grasps, seconds; NaN if unknown.
    """

    def __init__(
        self, table: pd.DataFrame, planning_time: float = float("nan"), scenes: Scenes | None = None
    ) -> None:
        """Wrap a table of `tables.clutter.CLUTTER`; `scenes` are needed to film its rounds."""
        self.table = table.reset_index(drop=True)
        self.planning_time = planning_time
        self._scenes = scenes

    def __repr__(self) -> str:
        """The rates of each kind of scene and noise, one per line."""
        rates = [
            f"{each.scene}, noise {each.noise}, {each.rounds} rounds: success {each.success}; "
            f"cleared {each.cleared}"
            for each in self.rates()
        ]
        return "\n".join([self._title(), *rates])

    def _repr_html_(self) -> str:
        """The same as a table, for notebooks."""
        return table_html(self._title(), pd.DataFrame(self.rates()))

    def _title(self) -> str:
        rules = [f", protocol {name}" for name in self.table["protocol"].unique() if name]
        where = f"{engine_names(self.table)}{''.join(rules)}"
        return f"Benchmark in {where}: {len(self.table)} attempts"

    def rates(self) -> list[Clearing]:
        """Success rate and share of objects cleared for each kind of scene and noise."""
        return clearing_rates(self.table)

    def compare(self, other: "Benchmark") -> list[ClearingComparison]:
        """The differences to another detector over rounds of the same scene; UserError if none."""
        return compare_clearing(self.table, other.table)

    def film(
        self, scene: SceneKind, number: int, out: str | Path, noise: NoiseName = "none"
    ) -> None:
        """Repeat a round exactly, without its detector, and film it.

        Args:
            scene: How the objects lay.
            number: Number of the round, from 0.
            out: File to write: `.gif`, or `.mp4` if ffmpeg is installed.
            noise: Noise added to the depth images.

        Raises:
            UserError: There is no such round, the file has another ending, or the table was read
                from a file.
        """
        path = as_path("out", out)
        check_ending(path, ENDINGS)
        if self._scenes is None:
            raise UserError("only results returned by `egad.run_benchmark` can be filmed")
        write_film(film_round(self.table, scene, noise, number, *self._scenes), path)


def run_benchmark(
    detect: Detect | str,
    objects: Dataset | Mapping[str, trimesh.Trimesh],
    gripper: Gripper | str = "panda",
    *,
    scenes: Sequence[SceneKind] = SCENE_KINDS,
    protocol: str | Mapping[str, Any] | ClutterProtocol = "egad",
    noise: Sequence[NoiseName] | None = None,
    rounds: int = 100,
    per_scene: int = 5,
    scale: tuple[float, float] | None = None,
    errors: str | Mapping[str, Any] | CellErrors = "none",
    seed: int = 0,
    rule: str = "paper",
    engine: EngineName = "mujoco",
    jobs: int = 1,
    keep_going: bool = False,
    grasps: Mapping[str, Grasps] | None = None,
) -> Benchmark:
    """Let a detector clear a table, as in the experiments of VGN (Breyer et al. 2020, section V).

    In each round some of the objects are put on the table: one alone, upright side by side, or in a
    pile. Six depth cameras look at them, the detector proposes grasps, and a hand without an arm
    carries out the best one. Whatever the hand then holds is removed. The round ends when nothing
    is left, nothing is proposed, or two attempts in a row have failed. Published benchmarks have
    other rules; `protocol` selects them.

    An error of the detector counts as a failed attempt. Its traceback is in the column `failure`;
    that of the first error is also logged. An endless loop is not interrupted.

    Args:
        detect: A function or object that is called with the input it asks for
            (`egad.detectors.wanted_input`), the gripper and a random generator, and returns poses,
            widths and scores (`egad.detectors.GraspPoses`), or grasps from above; or the name of a
            detector that needs no file: `antipodal-cloud`, `antipodal-depth`, `random`,
            `ggcnn2-evolved` or `vgn-evolved` (networks that egad ships; they need PyTorch);
            `suction-cloud`, `suction-depth` for a suction cup; or `labels`, which knows where the
            objects are and proposes the best of 100 sampled grasps of each.
        objects: A dataset, or meshes in metres by name.
        gripper: The gripper, or its name.
        scenes: Kinds of scenes: single, packed, pile.
        protocol: Rules of a published benchmark: egad, vgn, giga, edgegrasp; or your own.
        noise: Kinds of noise: none, stereo, gamma, dex, points; None for those of the protocol.
        rounds: Rounds of each kind of scene and noise.
        per_scene: Objects in packed and piled scenes.
        scale: Range of the sizes of the objects, relative to their sizes by the rule; None for that
            of the protocol.
        errors: Errors of a real cell, as for `egad.run_trials`.
        seed: The same seed gives the same scenes, for all detectors and kinds of noise.
        rule: How objects are scaled to the gripper: see `egad.rescale`.
        engine: What computes the physics: `mujoco`, `pybullet` or `drake`.
        jobs: Number of processes; the result does not depend on it.
        keep_going: Whether to go on with a detector that fails in every attempt of three rounds.
        grasps: For `labels`: grasps of each object, as for `egad.run_trials`.

    Raises:
        UserError: The detector fails in every attempt of three rounds, there is no such scene or
            noise, no object can be simulated, or as `egad.run_trials`.

    Warns:
        UnitsWarning: The size of a mesh suggests a unit other than the metre.
        PartsWarning: An object needs more convex parts than are allowed.
    """
    hand = hand_of(gripper, rule, engine)
    clutter = from_arguments(
        Clutter,
        engine=engine,
        scenes=tuple(scenes),
        protocol=protocol,
        noise=None if noise is None else tuple(noise),
        rounds=rounds,
        objects=per_scene,
        errors=errors,
    )
    if scale is not None:
        rules = dict(clutter.protocol) | {"scale": scale, "packed_scale": None}
        clutter = clutter.model_copy(update={"protocol": ClutterProtocol(**rules)})
    settings = from_arguments(ClutterParameters, seed=seed, gripper=hand, clutter=clutter)
    known = as_detector(detect, (LABELS, *SHIPPED_NETWORKS, *IN_SCENES))
    if not isinstance(known, DetectorConfig):
        wanted_input(known)
    targets = named_meshes(objects)
    labelled = labels_from(grasps, known, rule, targets)
    return try_tables(known, targets, settings, rule, jobs, keep_going, labelled)


def try_tables(
    detect: Detect,
    targets: Sequence[NamedMesh],
    settings: ClutterParameters,
    rule: str,
    jobs: int = 1,
    keep_going: bool = False,
    grasps: Mapping[str, pd.DataFrame] | None = None,
) -> Benchmark:
    """Let a detector clear tables, `labels` perhaps with `grasps` by id; see `run_benchmark`."""
    labelled = grasps or settings.seed if knows_scene(detect) else None
    given = (targets, settings.gripper, rule, labelled)
    released = set(load(EVALUATION_SET).table["id"])
    if all(each.id in released for each in targets):  # all of them can be simulated
        return clear_tables(detect, lazy_objects(*given), settings, jobs, keep_going)
    check_detector(detect, settings)
    usable = {each.id: each for each in prepare_objects(*given, jobs)}
    return clear_tables(detect, usable, settings, jobs, keep_going)


def clear_tables(
    detect: Detect,
    objects: Mapping[str, SceneObject],
    settings: ClutterParameters,
    jobs: int = 1,
    keep_going: bool = False,
) -> Benchmark:
    """Let a detector clear tables of objects by id; `labels` needs objects with grasps."""
    todo = rounds_of(list(objects), settings)
    single, rest = todo[:jobs], todo[jobs:]  # the first rounds are soon done
    shards = [[each] for each in single]
    count = max(jobs, min(SHARDS * jobs, len(rest) // FEWEST))
    shards += [shard for first in range(count) if (shard := rest[first::count])]
    work = partial(
        clear_rounds, objects=objects, detect=detect, settings=settings, keep_going=keep_going
    )
    seconds: list[float] = []
    monitor = FailureMonitor(len(todo), keep_going, "rounds")
    by_round = {}
    with workers(jobs) as mapper:
        done = _by_round(mapper(work, shards), seconds)
        for key, rows in progress(done, "clearing", len(todo)):
            monitor.check(rows)
            by_round[key] = rows
    return Benchmark(
        pd.concat([by_round[this[:3]] for this in todo]),
        float(np.median(seconds)) if seconds else float("nan"),
        Scenes(models_of(objects), settings),
    )


def _by_round(
    cleared: Iterable[Cleared], seconds: list[float]
) -> Iterator[tuple[Hashable, pd.DataFrame]]:
    """The attempts of each round; planning times are appended to `seconds`."""
    for table, times in cleared:
        seconds.extend(times)
        yield from table.groupby(ROUND, sort=False)
