"""Rounds of clearing a table as rows of a table, and rounds read back from rows."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from egad._util.arrays import RgbImage
from egad._util.progress import phase_if_slow
from egad.bench.clearing_runner import ClearingRunner
from egad.bench.parameters import ClutterParameters
from egad.bench.protocols import ClutterProtocol, SceneKind
from egad.bench.reproduction import END_TOLERANCE
from egad.bench.runner import Attempt, Propose
from egad.bench.scenes import BOX
from egad.detectors import Grasp, NoiseName
from egad.errors import UserError
from egad.geometry import nearest
from egad.random import entropy, generator
from egad.sim import Film, Model, World, free_hand, open_world, platform_of
from egad.tables import parquet
from egad.tables.clutter import CLUTTER, GRASP_POSE
from egad.tables.outcomes import Outcome

Models = Mapping[str, Model]

ENDS = ["attempt", "n_present", "success", "stopped"]  # of attempts


class Round(NamedTuple):
    """One round: which objects, their sizes relative to the models, and how they lie."""

    scene: SceneKind
    noise: NoiseName
    number: int
    seed: int
    ids: tuple[str, ...]
    factors: tuple[float, ...]


def round_name(scene: object, noise: object, number: object) -> str:
    """The name of a round in messages."""
    return f"round {number}, {scene}, noise {noise}"


def rounds_of(ids: Sequence[str], settings: ClutterParameters) -> list[Round]:
    """All rounds, by scene, noise, number; a scene depends on seed, number and the set of ids."""
    clutter = settings.clutter
    return [
        _round(sorted(ids), settings, scene, noise, number)
        for scene in clutter.scenes
        for noise in clutter.noises
        for number in range(clutter.rounds if ids else 0)
    ]


def _round(
    ids: Sequence[str], settings: ClutterParameters, scene: SceneKind, noise: NoiseName, number: int
) -> Round:
    rng = generator(settings.seed, "clutter", scene, number)
    count = 1 if scene == "single" else settings.clutter.objects
    chosen, factors = draw_objects(ids, scene, count, settings.clutter.protocol, rng)
    seed = entropy(settings.seed, "round", scene, number)
    return Round(scene, noise, number, seed, chosen, factors)


def draw_objects(
    ids: Sequence[str],
    scene: SceneKind,
    count: int,
    protocol: ClutterProtocol,
    rng: np.random.Generator,
) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Draw `count` objects and their sizes; fewer if the ids are few and may not repeat."""
    if protocol.repetition:
        chosen = rng.integers(len(ids), size=count)
    else:
        chosen = rng.permutation(len(ids))[:count]
    scale = protocol.packed_scale if scene == "packed" else None
    factors = rng.uniform(*scale or protocol.scale, size=len(chosen)).tolist()
    return tuple(ids[index] for index in chosen), tuple(factors)


def run_round(
    this: Round,
    models: Models,
    proposer: Callable[[Sequence[str], Sequence[Model]], Propose],
    settings: ClutterParameters,
) -> pd.DataFrame:
    """Let a detector clear a table: rows of `tables.clutter.CLUTTER`, one per attempt."""
    with open_round(this, models, settings) as world:
        runner = ClearingRunner(world, settings.clutter)
        propose = proposer(this.ids, world.models)
        attempts = list(runner.clear(propose, this.scene, this.noise, this.seed))
    return _table(this, world.models, attempts, settings)


def failed_round(this: Round, settings: ClutterParameters, outcome: Outcome) -> pd.DataFrame:
    """The table of a round that could not be simulated."""
    return _table(this, [], [Attempt(outcome, ())], settings)


def repeat_round(
    rows: pd.DataFrame,
    models: Models,
    settings: ClutterParameters,
    watch: Callable[[World], object] = lambda _: None,
) -> pd.DataFrame:
    """Repeat a round of `CLUTTER` bit by bit, without its detector; `watch` gets the world."""
    this = _read_round(rows.iloc[0])
    with open_round(this, models, settings) as world:
        watch(world)
        runner = ClearingRunner(world, settings.clutter)
        grasps = [read_grasp(row) for row in parquet.records(rows)]
        attempts = list(runner.repeat(grasps, this.scene, this.seed))
    return _table(this, world.models, attempts, settings)


@phase_if_slow("simulating and filming the round")
def film_round(
    table: pd.DataFrame,
    scene: str,
    noise: str,
    number: int,
    models: Models,
    settings: ClutterParameters,
) -> list[RgbImage]:
    """The frames of a repeated round; UserError if there is none, or it ends differently."""
    chosen = (table["scene"] == scene) & (table["noise"] == noise) & (table["round"] == number)
    rows = table[chosen].reset_index(drop=True)
    name = round_name(scene, noise, number)
    if rows.empty or not rows["n_objects"].iloc[0]:
        raise UserError(f"{name}: it is not in the table, or it never began")
    films: list[Film] = []
    again = repeat_round(rows, models, settings, lambda world: films.append(Film(world)))
    before, after = (each[ENDS].to_numpy(dtype=np.float64) for each in (rows, again))
    if len(before) != len(after) or not np.allclose(before, after, rtol=0.0, atol=END_TOLERANCE):
        raise UserError(
            f"{name} was not reproduced; settings, objects, machine or the version of the engine "
            "must differ from those of the round"
        )
    return films[0].frames


def picture_of(this: Round, models: Models, settings: ClutterParameters) -> RgbImage:
    """Picture of the initial scene of a round, (height, width, 3); UnstableError as for `begin`."""
    with open_round(this, models, settings) as world:
        ClearingRunner(world, settings.clutter).begin(this.scene, this.seed)
        return Film(world).frame()


def _read_round(row: pd.Series) -> Round:
    """The round that an attempt of a table belongs to."""
    factors = tuple(float(text) for text in row["factors"].split())
    return Round(
        row["scene"],
        row["noise"],
        int(row["round"]),
        int(row["seed"], 16),
        tuple(row["objects"].split()),
        factors,
    )


def read_grasp(row: Mapping[str, Any]) -> Grasp | Outcome:
    """The grasp tried in an attempt of a table, or why there was none."""
    numbers = np.array([row[name] for name in GRASP_POSE], dtype=np.float64)
    if np.isnan(numbers).any():
        return Outcome(row["outcome"])
    pose = np.eye(4)
    pose[:3] = numbers.reshape(3, 4)
    return Grasp.of_pose(pose, float(row["width"]), float(row["score"]))


def open_round(this: Round, models: Models, settings: ClutterParameters) -> World:
    """The world of a round, for a `with` block: objects at their sizes, a hand, perhaps walls."""
    sized = [models[name].scaled(by) for name, by in zip(this.ids, this.factors, strict=True)]
    walls = BOX if this.scene == "pile" else None
    protocol = settings.clutter.protocol
    given = {"force": protocol.force, "friction": protocol.friction}
    hand = settings.gripper.model_copy(
        update={name: value for name, value in given.items() if value is not None}
    )
    return open_world(settings.clutter.engine, sized, free_hand(hand), walls)


def _table(
    this: Round, models: Sequence[Model], attempts: Sequence[Attempt], settings: ClutterParameters
) -> pd.DataFrame:
    at_first = len(attempts[0].present) if attempts else 0
    known = {
        "scene": this.scene,
        "noise": this.noise,
        "round": this.number,
        "seed": f"{this.seed:032x}",
        "objects": " ".join(this.ids),
        "factors": " ".join(map(repr, this.factors)),
        "n_objects": at_first,
        "engine": settings.clutter.engine,
        "platform": platform_of(settings.clutter.engine),
        "protocol": settings.clutter.protocol.name,
        "errors": str(settings.clutter.errors),
    }
    rows = [
        known | {"attempt": number} | _columns_of(attempt, this, models)
        for number, attempt in enumerate(attempts)
    ]
    return pd.DataFrame(rows, columns=CLUTTER.names)


def _columns_of(attempt: Attempt, this: Round, models: Sequence[Model]) -> dict[str, Any]:
    grasp = attempt.grasp
    numbers = np.full(12, np.nan) if grasp is None else grasp.pose[:3].ravel()
    return {
        "n_present": len(attempt.present),
        "present": " ".join(this.ids[each.number] for each in attempt.present),
        **attempt.columns(),
        "id": "" if grasp is None else this.ids[_target(attempt, grasp, models)],
        **dict(zip(GRASP_POSE, numbers.tolist(), strict=True)),
        "width": np.nan if grasp is None else grasp.width,
        "score": np.nan if grasp is None else grasp.quality,
    }


def _target(attempt: Attempt, grasp: Grasp, models: Sequence[Model]) -> int:
    """Number of the object that was held, or of the one whose surface is nearest to the grasp."""
    if attempt.held is not None:
        return attempt.held
    center = grasp.pose[:3, 3]
    distances = []
    for number, pose in attempt.present:
        local = Rotation.from_quat(pose.quaternion).inv().apply(center - pose.position)
        distances.append(float(nearest(local[None], models[number].mesh)[0][0]))
    return attempt.present[int(np.argmin(distances))].number
