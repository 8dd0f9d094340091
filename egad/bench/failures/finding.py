"""Find the failures of a detector: resumable shards of a search, in parallel processes."""

import time
from collections.abc import Sequence
from contextlib import nullcontext
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from egad._util.files import as_path
from egad._util.parameters import from_arguments
from egad._util.progress import count_done, progress, shared_progress
from egad._util.workers import workers
from egad.bench.failures.atlas import FailureAtlas, merge
from egad.bench.failures.evidence import by_object, explanation
from egad.bench.failures.examine import Examination, approach_of
from egad.bench.failures.models import scaled_surface
from egad.bench.failures.parameters import (
    FailureParameters,
    FailureSearch,
    Strategy,
    check_searchable,
)
from egad.bench.failures.search import Search
from egad.bench.failures.store import NOTHING, Found, Store, joined
from egad.bench.parameters import ContactRule
from egad.detectors import IN_SCENES, SHIPPED_NETWORKS, Detect, DetectorConfig, as_detector, opened
from egad.errors import UserError
from egad.evalset import PrintCheck
from egad.evolution import Shape, evolution_parameters
from egad.geometry import Bundle, Material, Rescale
from egad.grasps import GraspLabel, label_parameters
from egad.grippers import Gripper, as_gripper
from egad.objects import Dataset, load
from egad.sim import FAST_ENGINES, EngineName, check_engine
from egad.tables import parquet
from egad.tables.failures import FAILURES

WRITING = 10.0  # seconds between writing the state of a search


def find_failures(
    detector: Detect | str,
    gripper: Gripper | str = "panda",
    *,
    objects: Dataset | None = None,
    attempts: int = 6000,
    strategy: Strategy = "evolution",
    approach: Literal["above", "any"] | None = None,
    depth_noise: float = 0.1,
    least_difference: float = 0.5,
    engines: Sequence[EngineName] | None = None,
    contact: Literal["collided", "close"] = "collided",
    stopping_force: float = 20.0,
    seed: int = 0,
    rule: str = "paper",
    shards: int = 2,
    jobs: int = 1,
    out: str | Path | None = None,
) -> FailureAtlas:
    """Find objects at which a detector fails although they can be grasped.

    An object is a failure if a reference, which knows where it lies and was chosen on other drops,
    holds it in at least 80 % of the attempts and at least 50 percentage points more often than the
    detector (`least_difference`), from the same poses, with 95 % confidence, in each engine; the
    shares are the defaults.
    Objects come from the released archive, from random genomes, and from children of the failures
    (MAP-Elites with the difference as objective).

    Args:
        detector: A function or object as for `egad.run_trials` or `egad.run_benchmark`; an
            `egad.detectors.DetectorConfig`, for example of a command; or a name.
        gripper: The gripper, or its name.
        objects: Objects with genomes to begin with; by default the released ones.
        attempts: Simulated grasps in all, including those of the reference. About 0.15 s each.
        strategy: screening: the objects; random: random genomes; mutation: children of the
            objects; evolution: the objects, random genomes and children of failures, mostly from
            the source that gives most failures per attempt.
        approach: `above`: grasps straight from above, as in `egad.run_trials`; `any`: in any
            direction, as in `egad.run_benchmark`. By default it depends on the detector's input.
        depth_noise: Noise of the depth images, pixels, as in `egad.run_trials`.
        least_difference: Minimum difference of the success rates of reference and detector at a
            failure, 0 to 1; use a lower value for a detector that rarely fails.
        engines: Physics engines; an object must be a failure in all of them. By default those that
            are installed.
        contact: What a contact on the way down means, as in `egad.run_trials`; with the approach
            `any`, the hand always closes where it was stopped.
        stopping_force: Contact force that stops the hand on its way down, newtons.
        seed: The same arguments give the same atlas.
        rule: How objects are scaled to the gripper: see `egad.rescale`.
        shards: Independent searches that share the attempts; at most this many run at once.
        jobs: Processes; the result does not depend on them.
        out: Folder for all results; an interrupted search resumes from it.

    Raises:
        UserError: The detector fails in every attempt at the first three objects, cannot be found
            or made, or is for another kind of gripper; the folder holds another search; an engine
            is not installed, or a number is out of range.

    Source: ours; the difference is the regret of PAIRED (Dennis et al. 2020), not learned.
    """
    hand = as_gripper(gripper)
    used = tuple(filter(find_spec, FAST_ENGINES)) if engines is None else tuple(engines)
    detect = as_detector(detector, (*SHIPPED_NETWORKS, *IN_SCENES))
    if isinstance(detect, DetectorConfig):
        check_searchable(detect, hand)
    search = from_arguments(
        FailureSearch,
        attempts=attempts,
        shards=shards,
        strategy=strategy,
        approach=approach,
        depth_noise=depth_noise,
        least_difference=least_difference,
        engines=used,
    )
    chosen = load() if objects is None else objects
    if not isinstance(chosen, Dataset):
        raise UserError("a search begins with a dataset of objects with genomes, not with meshes")
    settings = failure_parameters(
        hand,
        search,
        contact=from_arguments(ContactRule, contact=contact, stopping_force=stopping_force),
        seed=seed,
        rule=rule,
        shape=chosen.shape,
    )
    folder = None if out is None else as_path("out", out)
    return search_failures(chosen.archive, detect, settings, jobs, folder)


def failure_parameters(
    gripper: Gripper,
    search: FailureSearch,
    *,
    contact: ContactRule | None = None,
    seed: int = 0,
    rule: str = "paper",
    shape: Shape | None = None,
) -> FailureParameters:
    """The settings of a search, with defaults for everything that is not given."""
    return FailureParameters(
        seed=seed,
        gripper=gripper,
        rescale=from_arguments(Rescale, rule=rule),
        failures=search,
        trials=contact or ContactRule(),
        material=Material(),
        bundle=Bundle(),
        print_check=PrintCheck(),
        labels=label_parameters(gripper, GraspLabel().grasps, seed),
        breeding=evolution_parameters(seed).model_copy(update={"shape": shape or Shape()}),
    )


def search_failures(
    archive: pd.DataFrame,
    detect: Detect,
    settings: FailureParameters,
    jobs: int = 1,
    folder: Path | None = None,
) -> FailureAtlas:
    """Run all shards of a search that begins with `ARCHIVE`, or resume them, and join them."""
    search = settings.failures
    for engine in search.engines:
        check_engine(engine)
    store = None if folder is None else Store(folder, archive, detect, settings)
    with (
        nullcontext() if store is None else store.named_in_errors(),
        shared_progress("attempts", search.attempts) as done,
        workers(jobs) as mapper,
    ):
        work = partial(
            run_shard, archive=archive, detect=detect, settings=settings, store=store, done=done
        )
        found = list(mapper(work, range(search.shards)))
    atlas = join(found, detect, settings, jobs)
    if folder is not None:
        atlas.save(folder)
    return atlas


def run_shard(
    shard: int,
    archive: pd.DataFrame,
    detect: Detect,
    settings: FailureParameters,
    store: Store | None = None,
    done: Path | None = None,
) -> Found:
    """Run one shard of a search, or resume it; `done` is a file of `shared_progress`."""
    found = [NOTHING if store is None else store.read(shard)]
    report = int if done is None else partial(count_done, done)
    written = time.monotonic()
    with opened(detect, settings.planning_time) as asked:
        search = Search(archive, asked, settings, shard, found[0], report)
        report(search.spent)
        try:
            for step in search.steps():
                found.append(step)
                if store is not None and time.monotonic() - written > WRITING:
                    store.write(shard, joined(found))
                    written = time.monotonic()
        finally:
            if store is not None:
                store.write(shard, joined(found))
    return joined(found)


def join(
    shards: Sequence[Found], detect: Detect, settings: FailureParameters, jobs: int = 1
) -> FailureAtlas:
    """The atlas of all shards; the detector is asked again why it failed."""
    table, search = merge(shards, settings), settings.failures
    whole = joined(shards)
    known = by_object(whole.attempts)
    work = partial(_explained, known=known, detect=detect, settings=settings)
    with workers(jobs) as mapper:
        rows = parquet.records(table[["id", "voxels"]])
        further = list(progress(mapper(work, rows), "explaining", len(table)))
    attempts = pd.concat([whole.attempts, *further], ignore_index=True)
    known, engine = by_object(attempts), search.engines[0]
    reasons = [explanation(known[name], engine, search.explain) for name in table["id"]]
    explained = pd.DataFrame(reasons, index=table.index)
    failures = table.join(explained)[FAILURES.names] if len(table) else parquet.empty(FAILURES)
    with opened(detect, settings.planning_time) as asked:
        approach = approach_of(asked, search)
    search = search.model_copy(update={"approach": approach})
    kept = {name: getattr(settings, name) for name in FailureParameters.model_fields}
    settings = FailureParameters(**kept | {"failures": search})
    shape, name = settings.breeding.shape, name_of(detect)
    return FailureAtlas(failures, whole.examined, attempts, shape, settings, name)


def _explained(
    row: dict[str, Any], known: dict[str, pd.DataFrame], detect: Detect, settings: FailureParameters
) -> pd.DataFrame:
    mesh = scaled_surface(row["voxels"], settings)
    with opened(detect, settings.planning_time) as asked:
        return Examination(mesh, row["id"], asked, settings).explain(known[row["id"]])


def name_of(detect: Detect) -> str:
    """The name of a detector, or of its function or class."""
    if isinstance(detect, DetectorConfig):
        return detect.name
    return str(getattr(detect, "__name__", type(detect).__name__))
