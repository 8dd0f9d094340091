"""Difficulty: grasp difficulty of all objects for a gripper.

Inputs: results/D/objects.parquet, results/D/meshes.
Outputs: results/D/difficulty/G.parquet; made if targets.difficulty is true.
"""

from egad.config.stages import DifficultyOfGripper


rule difficulty:
    """Measure the difficulty of all objects of a dataset for a gripper."""
    input:
        objects="results/{dataset}/objects.parquet",
        meshes="results/{dataset}/meshes",
    output:
        out=ensure("results/{dataset}/difficulty/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/difficulty/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/difficulty/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: SIDE_BY_SIDE
    resources:
        **needs(mb=1000, mb_per_thread=500, minutes=60),
    params:
        settings=settings_of(DifficultyOfGripper),
        measures=MEASURES,
        code=code_of("difficulty"),
    message:
        "Measuring the difficulty of {wildcards.dataset} for {wildcards.gripper}"
    script:
        "../scripts/difficulty.py"
