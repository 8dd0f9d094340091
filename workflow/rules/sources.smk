"""Functions: the sources of archives and objects of a dataset. No rules here."""

import hashlib
import json
import os
from functools import cache
from pathlib import Path

from egad.io import EVERY_FILE, objects_in
from egad_workflow.shards import by_shard


def previous_archive(wildcards):
    """The merged archive of the previous epoch; none for the first."""
    epoch = int(wildcards.epoch)
    previous = f"results/{wildcards.dataset}/epochs/epoch-{epoch - 1}/archive.parquet"
    return [previous] if epoch else []


def final_archive(wildcards):
    """The archive of the last epoch, or the source archive of a dataset."""
    last = f"results/{wildcards.dataset}/epochs/epoch-{LAST_EPOCH}/archive.parquet"
    return [GIVEN.get(wildcards.dataset, last)]


def region_meshes(wildcards):
    """The mesh files of the envelope, the kept solid and the hole."""
    regions = [SETTINGS.envelope, SETTINGS.keep_solid, SETTINGS.hole]
    return [region.mesh for region in regions if region.mesh]


@cache
def meshes_by_shard(name):
    """For each shard of a dataset, its mesh files by the names of the objects."""
    dataset = SETTINGS.datasets[name]
    files = objects_in(Path(dataset.folder), dataset.pattern or EVERY_FILE)
    shards = by_shard(files, len(SHARDS))
    return [{each: str(files[each]) for each in names} for names in shards]


def raw_objects(wildcards):
    """The mesh files of a shard; none for other objects."""
    source = SETTINGS.datasets[wildcards.dataset].source
    if source != "meshes":
        return []
    return list(meshes_by_shard(wildcards.dataset)[int(wildcards.shard)].values())


def raw_archive(wildcards):
    """The archive that the objects of a dataset come from; none for meshes and primitives."""
    if SETTINGS.datasets[wildcards.dataset].source in ("meshes", "primitives"):
        return []
    return [f"results/{wildcards.dataset}/archive.parquet"]


def raw_state(wildcards):
    """A digest of the names of the objects of a shard, and of size and time of their files.

    A new file can rename another object, and an older file take the place of one.
    """
    if SETTINGS.datasets[wildcards.dataset].source != "meshes":
        return ""
    files = meshes_by_shard(wildcards.dataset)[int(wildcards.shard)]
    stats = {name: os.stat(file) for name, file in files.items()}
    state = [(name, files[name], each.st_size, each.st_mtime_ns) for name, each in stats.items()]
    return hashlib.sha256(json.dumps(state).encode()).hexdigest()


def known_ancestry(wildcards):
    """The ancestors of the objects of a dataset, if they are known."""
    return ancestry_of(wildcards.dataset)


def ancestry_of(name):
    """The same, by the name of the dataset."""
    if name in EVOLVED:
        return [f"results/{name}/ancestry.parquet"]
    return [str(released_ancestry())] if GIVEN.get(name) == str(released()) else []


def selection(wildcards):
    """How the evaluation set is chosen."""
    return SETTINGS.datasets[wildcards.dataset].selection


def given_labels(wildcards):
    """The file with the labels of an evaluation set that has been chosen already."""
    return only_if(
        selection(wildcards) == "labels", SETTINGS.datasets[wildcards.dataset].evaluation_set
    )


def gripper_of_prints(wildcards):
    """The gripper that chosen meshes of the user must be printable for; None for other objects."""
    if SETTINGS.select_eval.gripper or SETTINGS.datasets[wildcards.dataset].source != "meshes":
        return None
    return min(SETTINGS.targets.grippers, key=lambda name: SETTINGS.grippers[name].opening)


def dataset_of(wildcards):
    """The settings of a dataset: other units or another number of objects run it again."""
    return SETTINGS.datasets[wildcards.dataset].model_dump(mode="json", exclude={"evaluation_set"})
