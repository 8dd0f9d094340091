"""Simulated success rate: how often naive and antipodal grasps of each object succeed in simulation.

Inputs: results/D/grasps/G.parquet, with simulated labels; results/D/rescaled/G; convex parts.
Outputs: results/D/naive_grasps/G.parquet, one row per grasp; results/D/simulated/G.parquet, one row per
object; made if targets.simulated_labels is true.
Steps: naive grasps of shards of objects are tried; the tables of the shards are joined; the grasps of
each object are counted.
"""

from egad.bench import NaiveGrasps


localrules:
    simulated_success_rate,


rule naive_grasp:
    """Try naive grasps of the objects of a shard."""
    input:
        convex_parts="results/{dataset}/parts/convex_parts-{gripper}-{shard}.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
    output:
        out=ensure("results/{dataset}/parts/naive_grasps-{gripper}-{shard}.parquet", non_empty=True),
    log:
        "logs/{dataset}/naive_grasp/{gripper}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/naive_grasp/{gripper}-{shard}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=120),
    params:
        settings=settings_of(NaiveGrasps),
        meshes=subpath(input.scales, parent=True),
        code=code_of("naive_grasp"),
    message:
        "Trying naive grasps of {wildcards.gripper} on {wildcards.dataset}, shard {wildcards.shard}"
    script:
        "../scripts/naive_grasp.py"


use rule join as join_naive_grasps with:
    input:
        tables=parts("results/{dataset}/parts/naive_grasps-{gripper}-{shard}.parquet"),
    output:
        joined=ensure("results/{dataset}/naive_grasps/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_naive_grasps/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/join_naive_grasps/{gripper}.tsv"
    resources:
        **needs(mb=2000, minutes=10),
    params:
        by=["label", "place", "number"],
        code=code_of("join"),
    message:
        "Joining the naive grasps of {wildcards.gripper} on {wildcards.dataset}"


rule simulated_success_rate:
    """Count how often the simulated grasps of each object succeed."""
    input:
        grasps="results/{dataset}/grasps/{gripper}.parquet",
        naive="results/{dataset}/naive_grasps/{gripper}.parquet",
    output:
        out=ensure("results/{dataset}/simulated/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/simulated_success_rate/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/simulated_success_rate/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=10),
    params:
        code=code_of("simulated_success_rate"),
    message:
        "Counting simulated grasps of {wildcards.gripper} on {wildcards.dataset}"
    script:
        "../scripts/simulated_success_rate.py"
