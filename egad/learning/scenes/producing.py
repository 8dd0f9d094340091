"""Make labelled scenes of objects, from Python."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pandas as pd
import trimesh

from egad._util.files import as_path
from egad._util.parameters import SCALE_RULES, from_arguments
from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench import ClutterProtocol, SceneCameras
from egad.detectors import NoiseName
from egad.errors import RejectedError, UserError, check_name
from egad.evolution import Lineage
from egad.grippers import Gripper, as_gripper, check_jaws
from egad.learning.scenes.making import MadeScene, make_scene
from egad.learning.scenes.parameters import TRAINING_CAMERAS, SceneParameters, TrainingScenes
from egad.learning.scenes.planning import (
    PlannedScene,
    planned_scenes,
    scenes_of_shard,
    shard_count,
    split_objects,
    with_objects,
)
from egad.learning.scenes.reading import SceneDataset
from egad.learning.scenes.writing import describe_set, set_notes, write_shard
from egad.objects import Dataset, NamedMesh, named_meshes
from egad.sim import EngineName, Model, check_engine
from egad.sim.model import simulated
from egad.tables.objects import REJECTED


def make_scenes(
    objects: Dataset | Mapping[str, trimesh.Trimesh],
    gripper: Gripper | str = "panda",
    *,
    scenes: int = 100,
    pile: float = 0.5,
    per_scene: float = 5.0,
    grasps: int = 60,
    yaws: int = 5,
    protocol: str | Mapping[str, Any] | ClutterProtocol = "egad",
    cameras: SceneCameras | Mapping[str, Any] = TRAINING_CAMERAS,
    noise: Sequence[NoiseName] = ("none", "dex"),
    validation: float = 0.1,
    test: float = 0.1,
    hold_out: Collection[str] = (),
    seed: int = 0,
    rule: str = "paper",
    engine: EngineName = "mujoco",
    jobs: int = 1,
    out: str | Path | None = None,
) -> SceneDataset:
    """Make scenes of several objects with depth images and grasps labelled by simulation.

    Objects are packed upright or dropped into a pile. Six cameras see them from random directions.
    At random points of the visible surface, a hand approaches against the normal at several yaws,
    closes and retreats; the label is whether it lifts an object at any of these yaws. A contact
    during the approach is a failure if its force is more than the `stopping_force` of the protocol:
    20 N, or any force with the protocols of VGN and its successors. VGN is trained on such data
    (Breyer et al. 2020).

    Args:
        objects: A dataset, or meshes in metres by name.
        gripper: The gripper, with jaws, or its name.
        scenes: How many scenes; about 4 s each, after 2 to 5 s for each object that occurs in them,
            as it is split into convex parts.
        pile: Fraction of them that are piles; in the others, objects are packed.
        per_scene: Mean number of objects in a scene.
        grasps: Labelled grasps in each scene.
        yaws: Turns about the approach that are tried for each grasp, evenly over half a turn.
        protocol: Rules of a published benchmark as for `egad.run_benchmark`, or your own: sizes,
            packing, dropping, friction, forces and success.
        cameras: Ranges of the cameras, keys of `egad.bench.SceneCameras`.
        noise: Kinds of noise, one of which is drawn for each scene: none, stereo, gamma, dex,
            points.
        validation: Fraction of objects and scenes for validation.
        test: Fraction of objects and scenes for testing. No object is in two splits, and no family,
            if the ancestors of all objects are known.
        hold_out: Ids of objects that are in no scene, nor are their parents and children: those
            that networks will be tested on.
        seed: The same arguments give the same scenes.
        rule: How objects are scaled to the gripper: see `egad.rescale`.
        engine: What computes the physics: `mujoco`, `pybullet` or `drake`.
        jobs: Number of processes; the result does not depend on it.
        out: Folder for the scenes; without one, they are deleted together with the result.

    Raises:
        UserError: There are no objects that can be simulated, all are held out, or no scene could
            be made; none of the ids to hold out is known; the gripper has a suction cup; the folder
            is not empty; an argument is not allowed.

    Warns:
        UnitsWarning: The size of a mesh suggests a unit other than the metre.
        PartsWarning: An object needs more convex parts than are allowed.
    """
    hand = as_gripper(gripper)
    check_jaws(hand, "labelled scenes")
    check_name("rule", rule, SCALE_RULES)
    check_engine(engine)
    wanted = from_arguments(
        TrainingScenes,
        scenes=scenes,
        pile=pile,
        objects=per_scene,
        grasps=grasps,
        yaws=yaws,
        protocol=protocol,
        engine=engine,
        cameras=cameras,
        noise=tuple(noise),
        validation=validation,
        test=test,
        hold_out=False,
    )
    settings = from_arguments(SceneParameters, seed=seed, gripper=hand, scenes=wanted)
    targets = named_meshes(objects)
    ids = [each.id for each in targets]
    folder, keep = _folder(out)
    lineage = None
    if isinstance(objects, Dataset):
        with suppress(UserError):  # an archive that was never a file has none
            lineage = objects.lineage
    splits = split_objects(ids, lineage, _to_hold_out(hold_out, ids, lineage), settings)
    if not splits.split_of:
        raise UserError(f"all {len(ids)} objects are held out; leave some out of hold_out")
    planned = planned_scenes(splits.split_of, settings)
    drawn = {name for each in planned for name in each.round.ids}
    models, rejected = models_of([each for each in targets if each.id in drawn], hand, rule, jobs)
    plan = with_objects(planned, models)
    name = gripper if isinstance(gripper, str) else "a gripper"
    shards, about = shard_count(scenes), set_notes(settings, splits.split_of, name)
    work = partial(_made, settings=settings)
    with workers(jobs) as mapper:
        items = ((each, {name: models[name] for name in each.round.ids}) for each in plan)
        done = iter(progress(mapper(work, items), "making scenes", len(plan)))
        for shard in range(shards):
            mine = scenes_of_shard(plan, shard, shards, scenes)
            made = [each for _, each in zip(mine, done, strict=False) if each is not None]
            files = (folder / f"{name}-{shard}.parquet" for name in ("scenes", "grasps"))
            write_shard(made, shard, shards, about, *files)
    describe_set(folder, settings, f"Labelled scenes for {name}", len(planned), splits, rejected)
    return SceneDataset([folder], keep)


def _made(
    item: tuple[PlannedScene, Mapping[str, Model]], settings: SceneParameters
) -> MadeScene | None:
    """A scene, given with its models."""
    return make_scene(*item, settings)


def _to_hold_out(given: object, ids: Collection[str], lineage: Lineage | None) -> set[str]:
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise UserError(f"hold_out is {given!r}; allowed: a list of ids of objects")
    found = set(given)
    if found and not any(name in ids or (lineage and name in lineage) for name in found):
        raise UserError("hold_out has no id of these objects (`Dataset.table` has a column `id`)")
    return found


def _folder(out: str | Path | None) -> tuple[Path, object]:
    """An empty folder, and what removes it if it is not to stay."""
    if out is None:
        keep = TemporaryDirectory(prefix="egad-scenes-")
        return Path(keep.name), keep
    folder = as_path("out", out)
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UserError(f"{folder} is not an empty folder; name another one, or remove it")
    folder.mkdir(parents=True, exist_ok=True)
    return folder, None


def models_of(
    targets: Sequence[NamedMesh], gripper: Gripper, rule: str, jobs: int
) -> tuple[dict[str, Model], pd.DataFrame]:
    """Models by id, and the rejected objects (`REJECTED`); UserError if all of them are."""
    with workers(jobs) as mapper:
        work = partial(_model, gripper=gripper, rule=rule)
        made = list(progress(mapper(work, targets), "making models", len(targets)))
    pairs = list(zip(targets, made, strict=True))
    models = {each.id: model for each, model in pairs if isinstance(model, Model)}
    if not models:
        raise UserError(f"none of the objects can be simulated; {targets[0].label}: {made[0]}")
    rows = [
        {"id": each.id, "stage": "scenes", "reason": str(model)}
        for each, model in pairs
        if not isinstance(model, Model)
    ]
    return models, pd.DataFrame(rows, columns=REJECTED.names)


def _model(target: NamedMesh, gripper: Gripper, rule: str) -> Model | str:
    """An object as it is simulated, or why it cannot be."""
    try:
        return simulated(target, gripper, rule)[1]
    except RejectedError as reason:
        return str(reason)
