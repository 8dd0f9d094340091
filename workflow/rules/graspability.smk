"""Graspability of all objects for a gripper.

Inputs: results/D/objects.parquet, results/D/meshes.
Outputs: results/D/graspability/G.parquet; made if targets.graspability is true.
"""

from egad.measures import GraspabilityOfGripper


rule graspability:
    """Measure the graspability of all objects of a dataset for a gripper."""
    input:
        objects="results/{dataset}/objects.parquet",
        meshes="results/{dataset}/meshes",
    output:
        out=ensure("results/{dataset}/graspability/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/graspability/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/graspability/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=1000, mb_per_thread=500, minutes=60),
    params:
        settings=settings_of(GraspabilityOfGripper),
        measures=MEASURES,
        sampler=sampler_code,
        code=code_of("graspability"),
    message:
        "Measuring the graspability of {wildcards.dataset} for {wildcards.gripper}"
    script:
        "../scripts/graspability.py"
