"""Functions that the rules use, and the names that may stand in file names. No rules here."""

import hashlib
import json
import os
import sys
import time
from functools import cache
from pathlib import Path

from snakemake.exceptions import WorkflowError

from egad import stage_settings
from egad.code_version import code_version
from egad.config_check import check
from egad.data import released
from egad.errors import UserError
from egad.exchange.folders import EVERY_FILE, objects_in
from egad.exchange.sums import sum_of
from egad.measures.own import source_hash
from egad.stages.shards import by_shard
from egad.trials.files import fingerprint

try:
    SETTINGS = check(config)
    # The user's own measures by their code, so that editing it re-runs what they measure.
    MEASURES = [source_hash(measure) for _, measure in SETTINGS.axes if measure]
    # Files of detectors that are targets have to be there before anything runs.
    for name in SETTINGS.targets.policies:
        fingerprint(SETTINGS.policies[name])
except UserError as error:
    raise WorkflowError(f"The configuration cannot be used:\n{error}")

# A chain of epochs is as deep as it is long, and Snakemake walks it by recursion.
sys.setrecursionlimit(20_000)
# Jobs find the `egad` of this Python even if its environment is not activated.
os.environ.update(PATH=os.pathsep.join([str(Path(sys.executable).parent), *os.get_exec_path()]))

SHARDS = range(SETTINGS.shards)
# An evaluation set has an object a cell: more shards would be empty ones.
CELLS = SETTINGS.select_eval.rows * SETTINGS.select_eval.columns
EVALUATION_SHARDS = range(min(SETTINGS.shards, CELLS))
ISLANDS = range(SETTINGS.schedule.islands)
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
    policy="|".join(SETTINGS.policies),
    epoch=r"\d+",
    island=r"\d+",
    shard=r"\d+",


def settings_of(stage):
    """The settings that a stage reads, as JSON: its command gets them, its rule re-runs for them.

    A stage that reads a gripper gets the one in the file name, else the one of its own settings;
    the detector of the trials is also in the file name.
    """

    def chosen(wildcards):
        model = getattr(stage_settings, stage)
        names = wildcards.get("gripper"), wildcards.get("policy")
        part = stage_settings.select(SETTINGS, model, *names)
        return json.dumps(part.model_dump(mode="json"), separators=(",", ":"), sort_keys=True)

    return chosen


def labelled(wildcards):
    """The grasps that the detector `labels` knows; none for others."""
    knows = SETTINGS.policies[wildcards.policy].detector == "labels"
    return [f"results/{wildcards.dataset}/grasps/{wildcards.gripper}.parquet"] if knows else []


def touched_surface(wildcards):
    """The grasps that engraved labels keep away from; none without engraving."""
    file = f"results/{wildcards.dataset}/grasps/{wildcards.gripper}.parquet"
    return [file] if SETTINGS.engraving.enabled else []


def detector_code(wildcards):
    """The code and weights of a detector, so that editing them tries again."""
    try:
        return fingerprint(SETTINGS.policies[wildcards.policy])
    except UserError as error:
        raise WorkflowError(f"The detector {wildcards.policy} cannot be used: {error}")


def each(option, name):
    """An option with every file of a named input: `--solids A --solids B`."""
    return lambda wildcards, input: [
        word for file in getattr(input, name) for word in (option, str(file))
    ]


def named_grippers(option, files):
    """An option with a file of each target gripper: `--grasps G=A --grasps H=B`."""
    pairs = zip(SETTINGS.targets.grippers, files)
    return [word for gripper, file in pairs for word in (option, f"{gripper}={file}")]


def parts(pattern, shards=SHARDS):
    """The files of all shards."""
    return lambda wildcards: expand(pattern, shard=shards, **wildcards)


def previous_archive(wildcards):
    """The merged archive of the epoch before; none for the first."""
    epoch = int(wildcards.epoch)
    previous = f"results/{wildcards.dataset}/epochs/epoch-{epoch - 1}/archive.parquet"
    return [previous] if epoch else []


def final_archive(wildcards):
    """The archive of the last epoch, or the one that a dataset starts from."""
    last = f"results/{wildcards.dataset}/epochs/epoch-{LAST_EPOCH}/archive.parquet"
    return [GIVEN.get(wildcards.dataset, last)]


def region_meshes(wildcards):
    """The mesh files that the envelope, part and hole are read from."""
    regions = [SETTINGS.envelope, SETTINGS.part, SETTINGS.hole]
    return [region.mesh for region in regions if region.mesh]


def gripper_mesh(wildcards):
    """The mesh file of a gripper, if it has one."""
    mesh = SETTINGS.grippers[wildcards.gripper].mesh
    return [mesh] if mesh else []


@cache
def meshes_by_shard(name):
    """For each shard of a dataset, its mesh files by the names of the objects."""
    dataset = SETTINGS.datasets[name]
    try:
        files = objects_in(Path(dataset.folder), dataset.pattern or EVERY_FILE)
    except UserError as error:
        raise WorkflowError(f"The dataset {name} cannot be used: {error}")
    shards = by_shard(files, len(SHARDS))
    return [{each: str(files[each]) for each in names} for names in shards]


def contents_of(files):
    """A fingerprint of inputs that are not results, for which an older file may have been put.

    Snakemake runs a job again for params of the wildcards, not for those of its input.
    """
    made = "results/"
    return lambda wildcards: _contents(
        tuple(file for file in files(wildcards) if not file.startswith(made))
    )


@cache
def _contents(files):
    sums = [sum_of(Path(file)) for file in files if Path(file).exists()]
    return hashlib.sha256("".join(sums).encode()).hexdigest()[:16]


def check_results():
    """Stop before anything runs if nothing can be written, or would seem older than its inputs."""
    results = Path("results")
    if results.exists() and not os.access(results, os.W_OK):
        raise WorkflowError(
            f"{results.absolute()} cannot be written: read-only, or of another user"
        )
    files = (Path(folder, name) for folder, _, names in os.walk(results) for name in names)
    late = sorted(str(path) for path in files if _is_late(path))
    if late:
        raise WorkflowError(
            f"{late[0]} and {len(late) - 1} more are from the future: the clock was set back. Set it"
            " right; or, if `egad verify results` finds nothing wrong, give them the time of now:"
            " find results -newermt now -exec touch {} +"
        )


def _is_late(path):
    try:
        return path.lstat().st_mtime > time.time() + CLOCK_SKEW
    except FileNotFoundError:
        return False  # another run has replaced it


def raw_objects(wildcards):
    """What the objects of a shard are made from: the archive, or its mesh files in the folder."""
    if SETTINGS.datasets[wildcards.dataset].source != "meshes":
        return [f"results/{wildcards.dataset}/archive.parquet"]
    return list(meshes_by_shard(wildcards.dataset)[int(wildcards.shard)].values())


def raw_state(wildcards):
    """A digest of what the objects of a shard are called, and of size and time of their files.

    A new file can rename another object, and an older file take the place of one.
    """
    if SETTINGS.datasets[wildcards.dataset].source != "meshes":
        return ""
    files = meshes_by_shard(wildcards.dataset)[int(wildcards.shard)]
    stats = {name: os.stat(file) for name, file in files.items()}
    state = [(name, files[name], each.st_size, each.st_mtime_ns) for name, each in stats.items()]
    return hashlib.sha256(json.dumps(state).encode()).hexdigest()


def raw_options(wildcards):
    """The options of postprocess that say what the objects are made from.

    Without `input`, for Snakemake would not run it again for other units then.
    """
    dataset = SETTINGS.datasets[wildcards.dataset]
    if dataset.source != "meshes":
        return ["--archive", *raw_objects(wildcards)]
    pattern = ["--pattern", dataset.pattern] if dataset.pattern else []
    return ["--folder", dataset.folder, "--units", dataset.units, *pattern]


def of_datasets(datasets, files):
    """The same files of several datasets."""
    return expand("results/{dataset}/{file}", dataset=datasets, file=files)


def published():
    """What the report shows: all files for people, but the report itself."""
    targets = SETTINGS.targets
    of_gripper = [
        "rescaled/{gripper}/scales.parquet",
        "rescaled/{gripper}/rejected.parquet",
        "grasps/{gripper}.parquet",
        "grasps/{gripper}.tally.parquet",
        "grasps/{gripper}.rejected.parquet",
        "size_effect/{gripper}.parquet",
        "print/{gripper}/manifest.parquet",
    ]
    if targets.agreement:
        of_gripper.append("agreement/{gripper}.parquet")
    trials = "trials/{gripper}/{policy}.parquet"
    of_target = [
        "eval49.parquet",
        "eval49.rejected.parquet",
        "eval49/README.md",
        "eval49/contact-sheet.pdf",
        "eval49/trials.csv",
        *expand(of_gripper, gripper=targets.grippers),
        *expand(trials, gripper=targets.grippers, policy=targets.policies),
    ]
    return [
        "results/comparison.parquet",
        "results/comparison.svg",
        *of_datasets([*EVOLVED, *GIVEN], ["archive.parquet"]),
        *of_datasets(EVOLVED, ["history.parquet"]),
        *of_datasets(SETTINGS.datasets, ["objects.parquet", "rejected.parquet", "meshes"]),
        *of_datasets(targets.datasets, of_target),
    ]


def exported():
    """The labelled grasps in the formats of other programs that are asked for."""
    targets = SETTINGS.targets
    files = {"dexnet": "exchange/{gripper}.hdf5", "acronym": "exchange/{gripper}-acronym"}
    wanted = [files[name] for name in targets.exports]
    return of_datasets(targets.datasets, expand(wanted, gripper=targets.grippers))
