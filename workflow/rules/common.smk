"""Settings, wildcard constraints, and functions shared by rules. No rules here."""

import hashlib
import json
import os
import sys
import time
from functools import cache
from pathlib import Path

from snakemake.exceptions import WorkflowError

from egad.pipeline.cli.stages import stage_function
from egad.pipeline.config import training_study
from egad.pipeline.code_version import code_version
from egad.pipeline.config.check import check, check_engines
from egad.pipeline.config.input_files import check_export, check_input_files
from egad.pipeline.config.schema import schema
from egad.pipeline.config.stage_settings import select
from egad.pipeline.exports import (
    OF_OBJECTS,
    export_function,
    export_module,
    formats,
    last_files,
    sources,
)
from egad.pipeline.parameters import settings_type
from egad.data import released, released_ancestry
from egad.pipeline.display import start_display
from egad.errors import UserError
from egad.exchange import check_installed, checksum, missing_files
from egad.grippers import files_of
from egad._util.kernel_cache import compile_kernels
from egad._util.progress import MARKS
from egad.measures import source_hash
from egad.detectors import SHIPPED_WEIGHTS, fingerprint
from egad.perception import shard_count

try:
    SETTINGS = check_engines(check(config))
    # What is missing is named here, as Snakemake overlooks it where older results exist.
    check_input_files(SETTINGS)
    # The same, with the networks of the training study among the detectors.
    TRIED = training_study.with_networks(SETTINGS)
    # The user's own measures by their code, so that editing it re-runs what they measure.
    MEASURES = [source_hash(measure) for measure in SETTINGS.measures.functions().values()]
except UserError as error:
    raise WorkflowError(f"The configuration cannot be used:\n{error}")

# A chain of epochs is as deep as it is long, and Snakemake walks it by recursion.
sys.setrecursionlimit(20_000)
# The display shows the warnings and errors of jobs, which are marked in their logs.
os.environ[MARKS] = "1"
# Jobs find the `egad` of this Python even if its environment is not activated.
os.environ.update(PATH=os.pathsep.join([str(Path(sys.executable).parent), *os.get_exec_path()]))

# The report says what each setting means.
MEANINGS = hashlib.sha256(json.dumps(schema()).encode()).hexdigest()[:16]
SHARDS = range(SETTINGS.shards)
# An evaluation set has one object per cell: more shards would be empty ones.
CELLS = SETTINGS.select_eval.rows * SETTINGS.select_eval.columns
EVALUATION_SHARDS = range(min(SETTINGS.shards, CELLS))
IMAGE_SHARDS = range(shard_count(SETTINGS.render.images))
NETWORKS = {network.name: network for network in training_study.networks_of(SETTINGS)}
# The training study is for the first target.
GRIPPER = SETTINGS.targets.grippers[0]
ISLANDS = range(SETTINGS.schedule.islands)
# Some formats need them, e.g. ACRONYM: they say whether a grasp succeeded.
SIMULATES_LABELS = SETTINGS.targets.simulated_labels or any(
    "simulated_grasps" in sources(name, GRIPPER) for name in SETTINGS.targets.exports
)
LAST_EPOCH = SETTINGS.schedule.epochs - 1
EVOLVED = [name for name, dataset in SETTINGS.datasets.items() if dataset.source == "evolved"]
GIVEN = {
    name: str(released() if dataset.archive == "released" else dataset.archive)
    for name, dataset in SETTINGS.datasets.items()
    if dataset.source == "archive"
}
EVOLVED_DATASET = "|".join(EVOLVED) or "(?!)"  # patterns; the latter fits no name
ARCHIVED_DATASET = "|".join([*EVOLVED, *GIVEN]) or "(?!)"
ENVIRONMENT = "../../envs/egad.yaml"
CLOCK_SKEW = 60  # seconds that the clocks of a cluster may differ


wildcard_constraints:
    dataset="|".join(SETTINGS.datasets),
    gripper="|".join(SETTINGS.grippers),
    detector="|".join(TRIED.detectors),
    training_set="|".join(SETTINGS.training_sets),
    epoch=r"\d+",
    island=r"\d+",
    shard=r"\d+",
    seed=r"\d+",
    noise="none|stereo",


def settings_of(stage):
    """The settings that a stage reads, as JSON: its rule re-runs when they change.

    A stage that reads a gripper gets the one in the file name, otherwise the one of its own
    settings. The detector of the trials is also in the file name.
    """
    return lambda wildcards: _chosen(stage_function(stage), wildcards)


def settings_with_keep_going(stage):
    """The same for a stage that asks a detector, and with `keep_going`.

    Because of `input`, turning it on does not re-run finished trials.
    """
    return lambda wildcards, input: _selected(stage_function(stage), wildcards).model_dump_json()


def settings_of_export(name=None):
    """The same for the given format of an export; default: the one in the file name."""
    objects = SETTINGS.targets.export_objects
    return lambda wildcards: _chosen(export_function(name or wildcards.format, objects), wildcards)


def _chosen(function, wildcards):
    return _as_json(_selected(function, wildcards))


def _selected(function, wildcards):
    names = wildcards.get("gripper"), wildcards.get("detector")
    return select(TRIED, settings_type(function), *names)


def code_of(stage):
    """The code version of a stage: its rule re-runs when it changes."""
    return code_version(f"egad.pipeline.stages.{stage}")


def code_of_export(wildcards):
    """The same for the format in the file name."""
    return code_version(export_module(wildcards.format))


def exported_objects(wildcards):
    """The option that says which objects are written, for formats of objects."""
    given = ["--objects", SETTINGS.targets.export_objects]
    return given if wildcards.format in OF_OBJECTS else []


def exported_from(wildcards):
    """The inputs of the format in the file name; for a folder, the file that is written last."""
    try:
        check_export(wildcards.format, wildcards.gripper, SETTINGS)
    except UserError as error:
        raise WorkflowError(f"targets.exports: {error}")
    files = last_files(wildcards.format, wildcards.gripper, SETTINGS.targets.export_objects)
    return [f"results/{wildcards.dataset}/{file}" for file in files]


def _as_json(part):
    # whether a run goes on after failures of a detector changes no result
    values = part.model_dump(
        mode="json", exclude={"trials": {"keep_going"}, "clutter": {"keep_going"}}
    )
    return json.dumps(values, separators=(",", ":"), sort_keys=True)


def labelled(wildcards):
    """The labelled grasps for the detector `labels`; none for others."""
    knows = TRIED.detectors[wildcards.detector].detector == "labels"
    gripper = wildcards.get("gripper", GRIPPER)
    return [f"results/{wildcards.dataset}/grasps/{gripper}.parquet"] if knows else []


def touched_surface(wildcards):
    """The grasps that engraved labels avoid; none without engraving."""
    file = f"results/{wildcards.dataset}/grasps/{wildcards.gripper}.parquet"
    return [file] if SETTINGS.engraving.enabled else []


def island_count(wildcards, input):
    """The number of islands. Because of `input`, its changes do not re-run finished islands."""
    return len(ISLANDS)


def each(option, name):
    """An option repeated for all files of a named input: `--solids A --solids B`."""
    return lambda wildcards, input: [
        word for file in getattr(input, name) for word in (option, str(file))
    ]


def named_grippers(option, files):
    """An option repeated for the files of the target grippers: `--grasps G=A --grasps H=B`."""
    pairs = zip(SETTINGS.targets.grippers, files)
    return [word for gripper, file in pairs for word in (option, f"{gripper}={file}")]


def parts(pattern, shards=SHARDS):
    """The files of all shards."""
    return lambda wildcards: expand(pattern, shard=shards, **wildcards)


def held_out(wildcards):
    """The evaluation set, if it is held out for testing."""
    file = f"results/{wildcards.dataset}/eval49.parquet"
    return [file] if SETTINGS.render.hold_out else []


def parts_of_images(wildcards):
    """The convex parts of the objects, if images are made with a simulation."""
    file = f"results/{wildcards.dataset}/convex_parts/{wildcards.gripper}.parquet"
    return [file] if SETTINGS.render.needs_convex_parts else []


def gripper_files(wildcards):
    """The files that describe a gripper, if there are any; default: the first target."""
    return files_of_gripper(wildcards.get("gripper", GRIPPER))


@cache
def files_of_gripper(name):
    """The same, by its name."""
    return [str(path) for path in files_of(SETTINGS.grippers[name])]


def contents_of(files):
    """A checksum of inputs that are not results; an older file may have replaced them.

    Snakemake re-runs a job if params that depend on wildcards change, not on its input.
    """
    made = "results/"
    return lambda wildcards: _contents(
        tuple(file for file in files(wildcards) if not file.startswith(made))
    )


@cache
def _contents(files):
    sums = [checksum(Path(file)) for file in files if Path(file).exists()]
    return hashlib.sha256("".join(sums).encode()).hexdigest()[:16]


def again_if_incomplete(output):
    """No input; but if files are missing in the folder of an output, its job runs again.

    Snakemake sees that a folder is there, not what is in it. `SHA256SUMS` lists what was written.
    """

    def look(wildcards):
        path = Path(output.format(**wildcards))
        if missing_files(path if path.is_dir() else path.parent):
            workflow.dag.forcefiles.add(str(path))  # as `--forcerun` does
        return []

    return look


def check_results():
    """Stop early if results cannot be written, or if they are dated in the future."""
    results = Path("results")
    if results.exists() and not os.access(results, os.W_OK):
        raise WorkflowError(
            f"{results.absolute()} cannot be written: read-only, or owned by another user"
        )
    files = (Path(folder, name) for folder, _, names in os.walk(results) for name in names)
    late = sorted(str(path) for path in files if _is_late(path))
    if late:
        raise WorkflowError(
            f"{late[0]} and {len(late) - 1} more are dated in the future: the clock was set back."
            " Correct it; or, if `egad verify results` reports no problem, update their times:"
            " find results -newermt now -exec touch {} +"
        )


def _is_late(path):
    try:
        return path.lstat().st_mtime > time.time() + CLOCK_SKEW
    except FileNotFoundError:
        return False  # another run has replaced it


def of_datasets(datasets, files):
    """The same files of several datasets."""
    return expand("results/{dataset}/{file}", dataset=datasets, file=files)
