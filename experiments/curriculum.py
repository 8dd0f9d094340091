"""Does a network learn more from objects at which it fails than from as many others?

    python experiments/curriculum.py FOLDER --networks NETWORKS --scenes SCENES --ycb YCB --jobs 2

docs/studies/curriculum-plan.md says what is compared and why. NETWORKS has the networks that are
trained further, `0/weights.safetensors` to `2/weights.safetensors`; SCENES are the labelled scenes
of released objects that they were trained on; YCB is a folder with `*.ply`, metres. FOLDER keeps
all results, and a second call resumes where the first was interrupted. `FOLDER --show` prints the
tables of the results so far.
"""

import argparse
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import trimesh
from benchmark import cpu_time, ycb
from curriculum_tables import (
    ATLAS,
    BEFORE,
    DONE,
    KINDS,
    NETWORKS,
    SEARCHED_AGAIN,
    SPENT,
    TABLE,
    show,
)
from failures import unlike

import egad
from egad._util.arrays import Floats
from egad._util.files import atomic_output, write_text
from egad._util.workers import Mapper, workers
from egad.bench.failures import Examination, FailureAtlas, FailureParameters, ObjectVerdict
from egad.bench.failures.attempts import pairs_of
from egad.bench.failures.search import scaled_surface, surface_of
from egad.bench.failures.verdict import GRASPABLE
from egad.config.stages import TrainOnScenes
from egad.detectors import Detector, DetectorConfig, opened
from egad.errors import RejectedError
from egad.grippers import GRIPPERS
from egad.learning import VgnTraining
from egad.learning.scenes import load_scenes
from egad.random import generator
from egad.workflow.train import WEIGHTS
from egad.workflow.train_on_scenes import train_on_scenes

Objects = egad.Dataset | Mapping[str, trimesh.Trimesh]


class Searches(NamedTuple):
    """A search against each of the networks."""

    name: str
    attempts: int
    first_seed: int


GRIPPER = "panda"
LEARNT, HELD_OUT = Searches("learnt", 4000, 101), Searches("held-out", 12_000, 201)
AGAIN = ("failures", "random")  # kinds after which networks are searched again
SCENES = 300  # further scenes of each kind, of one object each
EXAMPLES = 4000
DROPS = 10  # of each held-out failure, in each engine
ROUNDS = 40
THRESHOLD = 0.1  # least quality of the grasps that networks propose, as in the study of scenes
LEAST = {"learnt": 10, "held-out": 5}  # fewest failures for a comparison


def main() -> None:
    """Make what is missing, then print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--networks", type=Path, help="folder of the networks")
    parser.add_argument("--scenes", type=Path, help="labelled scenes that they know")
    parser.add_argument("--ycb", type=Path, help="folder of meshes, metres")
    parser.add_argument(
        "--held-out", type=int, default=HELD_OUT.attempts, help="grasps of a search for the test"
    )
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--show", action="store_true", help="make nothing")
    given = parser.parse_args()
    if not given.show:
        if None in (given.networks, given.scenes, given.ycb):
            parser.error("--networks, --scenes and --ycb are needed, or --show")
        with workers(given.jobs) as mapper:
            make(given.folder, given.networks, given.scenes, given.ycb, given.held_out, mapper)
    show(given.folder)


def make(
    folder: Path, networks: Path, scenes: Path, meshes: Path, held_out_attempts: int, mapper: Mapper
) -> None:
    """Make all that is missing."""
    plans = LEARNT, HELD_OUT._replace(attempts=held_out_attempts)
    before = networks_before(networks)
    household = {each.id: each.mesh() for each in ycb(meshes)}
    tests: dict[str, Objects] = {"egad": egad.load("evaluation-set"), "ycb": household}
    trained_on, untrained = objects_in(scenes, "train"), objects_in(scenes, "validation", "test")
    searches = [
        (folder, plan, number, detector(weights), plan.name, objects)
        for plan, objects in zip(plans, (trained_on, untrained), strict=True)
        for number, weights in enumerate(before)
    ]
    atlases = [FailureAtlas.load(path) for path in starmap(mapper, search, searches)]
    learnt, held_out = atlases[:NETWORKS], atlases[NETWORKS:]
    chosen = further_objects(learnt)
    tried = tested_objects(held_out, chosen)
    found = {"learnt": len(chosen["failures"]), "held-out": len(tried)}
    if any(found[name] < least for name, least in LEAST.items()):
        show(folder)
        raise SystemExit(f"failures: {found}; needed: {LEAST}: nothing can be compared")
    settings = learnt[0].searched_with()
    further = [(folder / "scenes" / kind, some, settings) for kind, some in chosen.items()]
    starmap(mapper, further_scenes, further)
    after = {BEFORE: before} | {kind: networks_after(folder, kind) for kind in KINDS}
    trainings = [
        (weights, [scenes, folder / "scenes" / kind], before[number], number)
        for kind in KINDS
        for number, weights in enumerate(after[kind])
    ]
    starmap(mapper, train, trainings)
    retries = [
        (folder / f"held-out/{kind}-{number}", weights, tried, held_out)
        for kind, each in after.items()
        for number, weights in enumerate(each)
    ]
    starmap(mapper, try_failures, retries)
    clearings = [
        (folder / f"cleared-{test}/{kind}-{number}", weights, objects)
        for kind, each in after.items()
        for number, weights in enumerate(each)
        for test, objects in tests.items()
    ]
    starmap(mapper, clear, clearings)
    again_plan = HELD_OUT._replace(attempts=SEARCHED_AGAIN)
    again = [
        (folder, again_plan, number, detector(weights), kind, untrained)
        for kind in AGAIN
        for number, weights in enumerate(after[kind])
    ]
    starmap(mapper, search, again)


def starmap(
    mapper: Mapper, work: Callable[..., Any], calls: Iterable[tuple[Any, ...]]
) -> list[Any]:
    """The results of a function for each tuple of arguments."""
    return list(mapper(partial(_call, work), calls))


def _call(work: Callable[..., Any], arguments: tuple[Any, ...]) -> object:
    return work(*arguments)


def once(folder: Path, work: Callable[[], object]) -> None:
    """Fill a folder unless that was done before; keeps the total of its CPU seconds.

    Those of a process that is killed are lost.
    """
    if (folder / DONE).exists():
        return
    spent, begin = folder / SPENT, cpu_time()
    before = float(spent.read_text()) if spent.exists() else 0.0
    try:
        work()
    finally:
        write_text(spent, f"{before + cpu_time() - begin:.0f}\n")
    write_text(folder / DONE, "")


def detector(weights: Path) -> DetectorConfig:
    """A network as a detector."""
    return DetectorConfig(detector="vgn", weights=str(weights), threshold=THRESHOLD)


def networks_before(networks: Path) -> list[Path]:
    """The weights of each network before further training."""
    return [networks / f"{number}/{WEIGHTS}" for number in range(NETWORKS)]


def networks_after(folder: Path, kind: str) -> list[Path]:
    """The weights of each network after further training on a kind of objects."""
    return [folder / f"networks/{kind}-{number}/{WEIGHTS}" for number in range(NETWORKS)]


def ids_in(scenes: Path, *splits: str) -> list[str]:
    """The ids of the objects in scenes of some splits."""
    index = load_scenes(scenes).index
    return sorted(set(index["objects"][index["split"].isin(splits)].explode()))


def objects_in(scenes: Path, *splits: str) -> egad.Dataset:
    """The released objects in scenes of some splits; no family is in several splits."""
    return egad.load().select(ids_in(scenes, *splits))


def search(
    folder: Path,
    plan: Searches,
    number: int,
    asked: DetectorConfig,
    name: str,
    objects: egad.Dataset,
) -> Path:
    """Search for the failures of a network; returns the folder of their atlas."""
    out = folder / f"searches/{name}-{number}"
    once(
        out,
        lambda: egad.find_failures(
            asked,
            GRIPPER,
            objects=objects,
            attempts=plan.attempts,
            seed=plan.first_seed + number,
            shards=1,
            out=out / ATLAS,
        ),
    )
    return out / ATLAS


def atlases_of(folder: Path, searches: Searches) -> list[FailureAtlas]:
    """The failures of each network that some searches found."""
    return [
        FailureAtlas.load(folder / f"searches/{searches.name}-{number}/{ATLAS}")
        for number in range(NETWORKS)
    ]


def further_objects(atlases: Iterable[FailureAtlas]) -> dict[str, pd.DataFrame]:
    """Equally many objects of each kind, by its name, from those that searches found graspable.

    Random ones are sampled from all of these. Hard ones are not failures of any network: for each
    failure, the most similar such object, by complexity and the logarithm of graspability, both in
    units of their standard deviation among the failures.
    """
    examined = pd.concat([each.examined for each in atlases])
    graspable = examined[examined["verdict"].isin(GRASPABLE)]
    fails = graspable["verdict"] == ObjectVerdict.FAILURE
    failures = graspable[fails].drop_duplicates("id")
    every = graspable.drop_duplicates("id")
    others = every[~every["id"].isin(set(failures["id"]))]
    drawn = generator(0, "further objects").permutation(len(every))[: len(failures)]
    return {
        "failures": failures,
        "random": every.iloc[np.sort(drawn)],
        "hard": others.iloc[most_similar(_axes(failures), _axes(others))],
    }


def _axes(objects: pd.DataFrame) -> Floats:
    values = [objects["complexity"], np.log(objects["graspability"].clip(lower=1e-9))]
    return np.column_stack(values).astype(np.float64)


def most_similar(wanted: Floats, among: Floats) -> list[int]:
    """For each wanted point, in order, the nearest one of the others that is not taken yet.

    Raises:
        ValueError: There are fewer points than are wanted.
    """
    if len(among) < len(wanted):
        raise ValueError(f"{len(wanted)} objects are wanted, and there are {len(among)}")
    scale = wanted.std(axis=0)
    taken: list[int] = []
    for point in wanted:
        distances = np.linalg.norm((among - point) / np.where(scale > 0, scale, 1), axis=1)
        distances[taken] = np.inf
        taken.append(int(np.argmin(distances)))
    return taken


def tested_objects(
    atlases: Iterable[FailureAtlas], chosen: Mapping[str, pd.DataFrame]
) -> dict[str, bool]:
    """The ids of failures that are unlike each other, and whether no training object is like them.

    Those without a similar training object come first.
    """
    known = (voxels for objects in chosen.values() for voxels in objects["voxels"])
    failures = pd.concat([each.table for each in atlases])
    new = failures.iloc[unlike(failures["voxels"], known)]
    others = failures.iloc[unlike(failures["voxels"], new["voxels"])]
    return dict.fromkeys(new["id"], True) | dict.fromkeys(others["id"], False)


def further_scenes(
    folder: Path,
    objects: pd.DataFrame,
    settings: FailureParameters,
    scenes: int = SCENES,
    share: float = 0,
) -> None:
    """Labelled scenes of one object each; if they were interrupted, all are made again.

    A share of them is for validation, and another one for the test.
    """

    def work() -> None:
        shutil.rmtree(folder, ignore_errors=True)
        pairs = zip(objects["id"], objects["voxels"], strict=True)
        meshes = {name: surface_of(voxels, settings) for name, voxels in pairs}
        egad.make_scenes(
            meshes,
            GRIPPER,
            scenes=scenes,
            per_scene=1,
            validation=share,
            test=share,
            out=folder,
        )

    once(folder, work)


def train(weights: Path, scenes: list[Path], start: Path, number: int) -> None:
    """Train a network further; it is written to the folder of its weights."""
    plan = VgnTraining(examples=EXAMPLES)
    settings = TrainOnScenes(seed=number, training_vgn=plan, gripper=GRIPPERS[GRIPPER])
    out = weights.parent
    once(out, lambda: train_on_scenes(settings, GRIPPER, scenes, out, start=start))


def try_failures(
    out: Path, weights: Path, tested: Mapping[str, bool], atlases: Sequence[FailureAtlas]
) -> None:
    """Try a network at failures of some atlases, from fresh drops."""
    settings = atlases[0].searched_with()

    def work() -> None:
        with opened(detector(weights), settings.failures.planning_time) as asked:
            rows = [
                row | {"is_new": is_new}
                for name, is_new in tested.items()
                for row in retried(name, _one_with(name, atlases), asked)
            ]
        write(pd.DataFrame(rows), out)

    once(out, work)


def _one_with(name: str, atlases: Sequence[FailureAtlas]) -> FailureAtlas:
    return next(atlas for atlas in atlases if name in set(atlas.table["id"]))


def retried(name: str, atlas: FailureAtlas, asked: Detector) -> list[dict[str, object]]:
    """Counts of a failure in each engine; none if it does not come to rest."""
    settings = atlas.searched_with()
    voxels = atlas.table["voxels"][atlas.table["id"] == name].iloc[0]
    past = atlas.attempts[atlas.attempts["id"] == name]
    examination = Examination(scaled_surface(voxels, settings), name, asked, settings)
    try:
        found = examination.paired("again", DROPS, past)
    except RejectedError:
        return []
    pairs = {engine: pairs_of(found, engine, "again") for engine in settings.failures.engines}
    return [
        {
            "id": name,
            "engine": engine,
            "n": len(each),
            "detector": sum(pair.detector for pair in each),
            "reference": sum(pair.reference for pair in each),
        }
        for engine, each in pairs.items()
    ]


def clear(out: Path, weights: Path, objects: Objects) -> None:
    """Let a network clear piles."""

    def work() -> None:
        found = egad.run_benchmark(
            detector(weights), objects, GRIPPER, scenes=["pile"], noise=["none"], rounds=ROUNDS
        )
        write(found.table, out)

    once(out, work)


def write(table: pd.DataFrame, folder: Path) -> None:
    """Put a table into a folder."""
    with atomic_output(folder / TABLE) as temporary:
        table.to_parquet(temporary)


if __name__ == "__main__":
    main()
