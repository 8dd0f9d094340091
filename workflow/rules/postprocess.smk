"""Postprocess: repaired meshes with mass properties and graspability without selection bias.

Inputs: results/D/archive.parquet, the mesh folder of the dataset, or nothing for primitives.
Outputs: results/D/objects.parquet, results/D/meshes/LABEL.obj (metres), results/D/rejected.parquet.
Steps: shards of objects are repaired and measured; then all get cells, labels and diversities.
"""

from egad.measures import CellsAndDiversities
from egad.evolution import PostprocessSolids


rule postprocess:
    """Repair and measure the objects of a shard."""
    input:
        raw_objects,
        archive=raw_archive,
    output:
        solids=ensure("results/{dataset}/parts/solids-{shard}.parquet", non_empty=True),
        rejected=ensure("results/{dataset}/parts/rejected-{shard}.parquet", non_empty=True),
    log:
        "logs/{dataset}/postprocess/{shard}.log",
    benchmark:
        "benchmarks/{dataset}/postprocess/{shard}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1500, minutes=30),
    params:
        settings=settings_of(PostprocessSolids),
        dataset=dataset_of,
        state=raw_state,
        measures=MEASURES,
        shard=shard_of(len(SHARDS)),
        code=code_of("postprocess"),
    message:
        "Repairing and measuring {wildcards.dataset}, shard {wildcards.shard}"
    script:
        "../scripts/postprocess.py"


rule collect:
    """Combine the shards: cells, labels, diversities and meshes of a whole dataset."""
    input:
        again_if_incomplete("results/{dataset}/meshes"),
        solids=parts("results/{dataset}/parts/solids-{shard}.parquet"),
        rejects=parts("results/{dataset}/parts/rejected-{shard}.parquet"),
    output:
        objects=ensure("results/{dataset}/objects.parquet", non_empty=True),
        rejected=ensure("results/{dataset}/rejected.parquet", non_empty=True),
        meshes=directory("results/{dataset}/meshes"),
    log:
        "logs/{dataset}/collect.log",
    benchmark:
        "benchmarks/{dataset}/collect.tsv"
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=2000, mb_per_thread=1000, minutes=30),
    params:
        settings=settings_of(CellsAndDiversities),
        source=lambda wildcards: SETTINGS.datasets[wildcards.dataset].source,
        code=code_of("collect"),
    message:
        "Collecting the objects of {wildcards.dataset}"
    script:
        "../scripts/collect.py"
