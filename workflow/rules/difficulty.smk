"""Difficulty: grasp difficulty of all objects for a gripper.

Inputs: results/D/objects.parquet, results/D/meshes.
Outputs: results/D/difficulty/G.parquet; made if targets.difficulty is true.
"""


rule difficulty:
    """Measure the difficulty of all objects of a dataset for a gripper."""
    input:
        objects="results/{dataset}/objects.parquet",
        meshes="results/{dataset}/meshes",
    output:
        ensure("results/{dataset}/difficulty/{gripper}.parquet", non_empty=True),
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
        settings=settings_of("difficulty"),
        measures=MEASURES,
        code=code_of("difficulty"),
    message:
        "Measuring the difficulty of {wildcards.dataset} for {wildcards.gripper}"
    shell:
        "egad difficulty --settings {params.settings:q} --objects {input.objects:q}"
        " --meshes {input.meshes:q} --out {output:q} --jobs {threads} > {log:q} 2>&1"
