"""Settings, wildcard constraints, and functions shared by rules. No rules here."""

import hashlib
import json
import os
import sys
import time
from functools import cache
from pathlib import Path

from snakemake.exceptions import WorkflowError

from egad_workflow.code_version import code_version
from egad_workflow.check import check, check_engines
from egad_workflow.input_files import check_input_files, is_result
from egad_workflow.check import schema
from egad_workflow.settings import select
from egad.exchange import (
    FORMATS,
    NamedGripper,
    check_format,
    files_of_grasps,
    last_files,
    module_of,
    modules_of_format,
    settings_class,
    sources,
)
from egad.data import released, released_ancestry
from egad_workflow.display import explain_reasons, start_display
from egad_workflow.input_files import contents
from egad_workflow.settings import plain
from egad.errors import UserError
from egad.grippers import files_of
from egad.io import files_below, missing_files
from egad._util.kernel_cache import compiled_marker
from egad._util.progress import MARKS
from egad.plugins import source_hash
from egad.grasps.samplers import own_samplers
from egad.detectors import NETWORKS, fingerprint, knows_scene
from egad.learning.images import shard_count
from egad.learning.scenes import shard_count as scene_shard_count

try:
    SETTINGS = check_engines(check(config))
    # Missing files are named here, as Snakemake overlooks them where older results exist.
    check_input_files(SETTINGS)
    # The user's own measures by their code, so that editing them re-runs what they measure.
    MEASURES = [
        source_hash(measure, "measures") for measure in SETTINGS.measures.functions().values()
    ]
    MEASURES += own_samplers([SETTINGS.grippers[SETTINGS.graspability.gripper]])
except UserError as error:
    raise WorkflowError(f"The configuration cannot be used:\n{error}")

# Snakemake follows a chain of epochs by recursion, one level per epoch.
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
SCENE_SHARDS = range(scene_shard_count(SETTINGS.scenes.scenes))
FAILURE_SHARDS = range(SETTINGS.failures.shards)
ISLANDS = range(SETTINGS.schedule.islands)
# Some formats, such as ACRONYM, need simulated labels to say whether a grasp succeeded.
SIMULATES_LABELS = SETTINGS.targets.simulated_labels or any(
    "simulated_grasps" in sources(name, SETTINGS.targets.grippers[0])
    for name in SETTINGS.targets.exports
)
LAST_EPOCH = SETTINGS.epochs - 1
EVOLVED = [name for name, dataset in SETTINGS.datasets.items() if dataset.source == "evolved"]
GIVEN = {
    name: str(released() if dataset.archive == "released" else dataset.archive)
    for name, dataset in SETTINGS.datasets.items()
    if dataset.source == "archive"
}
# Coverage of the map says nothing about a few meshes of the user.
COMPARED = any(dataset.source != "meshes" for dataset in SETTINGS.datasets.values())
NOTHING_HELD_OUT = SETTINGS.model_copy(
    update={
        name: getattr(SETTINGS, name).model_copy(update={"hold_out": False})
        for name in ("render", "scenes")
    }
)
EVOLVED_DATASET = "|".join(EVOLVED) or "(?!)"  # patterns; the latter matches no name
ARCHIVED_DATASET = "|".join([*EVOLVED, *GIVEN]) or "(?!)"
ENVIRONMENT = "../../envs/egad.yaml"
CLOCK_SKEW = 60  # seconds by which the clocks of a cluster may differ


wildcard_constraints:
    dataset="|".join(SETTINGS.datasets),
    gripper="|".join(SETTINGS.grippers),
    detector="|".join(SETTINGS.detectors),
    epoch=r"\d+",
    island=r"\d+",
    shard=r"\d+",


def settings_of(stage):
    """The settings that a stage reads, from the class that lists them: changes re-run its rule.

    A stage that reads a gripper gets the one in the file name, otherwise the one of its own
    settings. The detector of the trials is also in the file name.
    """
    return lambda wildcards: _selected(stage, wildcards)


def settings_of_export(name=None):
    """The same for the given format of an export; default: the one in the file name."""
    objects = SETTINGS.targets.export_objects
    return lambda wildcards: _selected(settings_class(name or wildcards.format, objects), wildcards)


def _selected(stage, wildcards):
    settings = settings_for(wildcards)
    return plain(select(settings, stage, wildcards.get("gripper"), wildcards.get("detector")))


def settings_for(wildcards):
    """The settings; nothing is held out where the evaluation set is the whole dataset."""
    dataset = SETTINGS.datasets.get(wildcards.get("dataset"))
    return NOTHING_HELD_OUT if dataset and dataset.selection == "all" else SETTINGS


def get_held_out_input(section):
    """The evaluation set, if training sets of a section leave it out."""

    def look(wildcards):
        wanted = getattr(settings_for(wildcards), section).hold_out
        return only_if(wanted, f"results/{wildcards.dataset}/eval49.parquet")

    return look


def keep_going(wildcards, input):
    """Whether to go on after failures. Because of `input`, this re-runs no finished trials."""
    return SETTINGS.keep_going


def code_of(script):
    """The version of what a script uses: its rule re-runs when it changes."""
    return code_version(workflow.source_path(f"../scripts/{script}.py"))


def code_of_format(script):
    """The same, with the version of the format in the file name."""

    def versions(wildcards):
        modules = modules_of_format(wildcards.format)
        return "-".join([code_of(script), *map(code_version, modules)])

    return versions


def shard_of(count):
    """The number of a shard in the file name, and the number of shards."""
    return lambda wildcards: [int(wildcards.shard), count]


def exported_from(wildcards):
    """The inputs of the format in the file name; for a folder, the file that is written last."""
    try:
        hand = NamedGripper(wildcards.gripper, SETTINGS.grippers[wildcards.gripper])
        check_format(wildcards.format, hand)
    except UserError as error:
        raise WorkflowError(f"targets.exports: {error}")
    files = last_files(wildcards.format, wildcards.gripper, SETTINGS.targets.export_objects)
    return [f"results/{wildcards.dataset}/{file}" for file in files]


def labelled(wildcards):
    """The labelled grasps for the detector `labels`, or the files of known grasps, if any."""
    detector = SETTINGS.detectors[wildcards.detector]
    if detector.known_grasps:
        return [str(path) for path in files_of_grasps(detector.known_grasps)]
    file = f"results/{wildcards.dataset}/grasps/{wildcards.gripper}.parquet"
    return only_if(knows_scene(detector), file)


def weights_of_detector(wildcards):
    """The weights of a detector, if a workflow makes them."""
    weights = SETTINGS.detectors[wildcards.detector].weights
    return [weights] if weights and is_result(weights) else []


def detector_code(wildcards):
    """The code of a detector, and its weights if no workflow makes them: trials depend on them."""
    detector = SETTINGS.detectors[wildcards.detector]
    if weights_of_detector(wildcards):
        if ":" not in detector.name:
            return []
        detector = detector.model_copy(update={"weights": None})
    try:
        return fingerprint(detector)
    except UserError as error:
        raise WorkflowError(f"The detector {wildcards.detector} cannot be used: {error}")


def parts(pattern, shards=SHARDS):
    """The files of all shards."""
    return lambda wildcards: expand(pattern, shard=shards, **wildcards)


def only_if(wanted, file):
    """An input that depends on a setting."""
    return [file] if wanted else []


def gripper_files(wildcards):
    """The files that describe a gripper, if there are any."""
    return files_of_gripper(wildcards.gripper)


def sampler_code(wildcards):
    """The code of a gripper's own sampler, if it has one."""
    return own_samplers([SETTINGS.grippers[wildcards.gripper]])


@cache
def files_of_gripper(name):
    """The files that describe a gripper, by its name."""
    return [str(path) for path in files_of(SETTINGS.grippers[name])]


def contents_of(*inputs):
    """A checksum of inputs that are not results; an older file may have replaced them.

    Snakemake re-runs a job if params that depend on wildcards change, not on its input.
    """
    return lambda wildcards: contents(file for each in inputs for file in each(wildcards))


def again_if_incomplete(output):
    """No input; but if files are missing in the folder of an output, its job runs again.

    Snakemake sees that a folder exists, not what is in it. `SHA256SUMS` lists what was written.
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
    files = files_below(results) if results.exists() else []
    late = sorted(str(path) for path in files if _is_late(path))
    if late:
        raise WorkflowError(
            f"{late[0]} and {len(late) - 1} more are dated in the future: the clock was set back."
            " Correct it; or, if `egad verify results` reports no problem, update their times:"
            " find -L results -newermt now -exec touch {} +"
        )


def _is_late(path):
    try:
        return path.lstat().st_mtime > time.time() + CLOCK_SKEW
    except FileNotFoundError:
        return False  # another run has replaced it


def of_datasets(datasets, files):
    """The same files of several datasets."""
    return expand("results/{dataset}/{file}", dataset=datasets, file=files)
