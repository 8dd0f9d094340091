"""Convex parts, which represent each object in simulators.

Inputs: results/D/objects.parquet, results/D/rescaled/G.
Outputs: results/D/convex_parts/G.parquet, one row per part.
Steps: shards of objects are decomposed, then the tables of the shards are joined. Simulated labels need
the parts of a shard.
"""

from egad.sim import SimulationBundle


rule convex_parts:
    """Make the convex parts of the objects of a shard."""
    input:
        objects="results/{dataset}/objects.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
    output:
        out=ensure("results/{dataset}/parts/convex_parts-{gripper}-{shard}.parquet", non_empty=True),
    log:
        "logs/{dataset}/convex_parts/{gripper}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/convex_parts/{gripper}-{shard}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1500, minutes=60),
    params:
        settings=settings_of(SimulationBundle),
        meshes=subpath(input.scales, parent=True),
        shard=shard_of(len(SHARDS)),
        code=code_of("convex_parts"),
    message:
        "Making convex parts of {wildcards.dataset} for {wildcards.gripper}, shard {wildcards.shard}"
    script:
        "../scripts/convex_parts.py"


use rule join as join_convex_parts with:
    input:
        tables=parts("results/{dataset}/parts/convex_parts-{gripper}-{shard}.parquet"),
    output:
        joined=ensure("results/{dataset}/convex_parts/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_convex_parts/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/join_convex_parts/{gripper}.tsv"
    resources:
        **needs(mb=2000, minutes=10),
    params:
        by=["label", "part"],
        code=code_of("join"),
    message:
        "Joining the convex parts of {wildcards.dataset} for {wildcards.gripper}"
