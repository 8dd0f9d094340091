"""Grasp-label: grasps with nominal and robust quality.

Inputs: results/D/objects.parquet, results/D/rescaled/G.
Outputs: results/D/grasps/G.parquet; G.sampling.parquet, the sampling statistics of each object;
G.rejected.parquet, the objects without grasps.
Steps: shards of objects are labelled; if targets.simulated_labels is true, or an export needs
simulated labels, their grasps are simulated; then the tables of the shards are joined.
"""

from egad.sim import SimulatedLabels
from egad.grasps import LabelParameters


localrules:
    join_sampling,
    join_ungraspable,


rule grasp_label:
    """Label the grasps of the objects of a shard."""
    input:
        objects="results/{dataset}/objects.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
        hand=gripper_files,
    output:
        out=ensure("results/{dataset}/parts/grasps-{gripper}-{shard}.parquet", non_empty=True),
        sampling=ensure(
            "results/{dataset}/parts/sampling-{gripper}-{shard}.parquet", non_empty=True
        ),
        rejected=ensure(
            "results/{dataset}/parts/ungraspable-{gripper}-{shard}.parquet",
            non_empty=True,
        ),
    log:
        "logs/{dataset}/grasp_label/{gripper}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/grasp_label/{gripper}-{shard}.tsv"
    priority: 1  # before trials, which can run beside the datasheet that waits for all grasps
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, minutes=30),
    params:
        settings=settings_of(LabelParameters),
        meshes=subpath(input.scales, parent=True),
        shard=shard_of(len(SHARDS)),
        contents=contents_of(gripper_files),
        sampler=sampler_code,
        code=code_of("grasp_label"),
    message:
        "Labelling grasps of {wildcards.gripper} on {wildcards.dataset}, shard {wildcards.shard}"
    script:
        "../scripts/grasp_label.py"


rule simulated_label:
    """Simulate the labelled grasps of the objects of a shard."""
    input:
        grasps="results/{dataset}/parts/grasps-{gripper}-{shard}.parquet",
        convex_parts="results/{dataset}/parts/convex_parts-{gripper}-{shard}.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
    output:
        out=ensure("results/{dataset}/parts/simulated-{gripper}-{shard}.parquet", non_empty=True),
    log:
        "logs/{dataset}/simulated_label/{gripper}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/simulated_label/{gripper}-{shard}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=60),
    params:
        settings=settings_of(SimulatedLabels),
        meshes=subpath(input.scales, parent=True),
        code=code_of("simulated_label"),
    message:
        "Simulating grasps of {wildcards.gripper} on {wildcards.dataset}, shard {wildcards.shard}"
    script:
        "../scripts/simulated_label.py"


use rule join as join_grasps with:
    input:
        tables=parts(
            "results/{dataset}/parts/simulated-{gripper}-{shard}.parquet"
            if SIMULATES_LABELS
            else "results/{dataset}/parts/grasps-{gripper}-{shard}.parquet"
        ),
    output:
        joined=ensure("results/{dataset}/grasps/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_grasps/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/join_grasps/{gripper}.tsv"
    resources:
        **needs(mb=2000, minutes=10),
    params:
        by=["label", "grasp"],
        code=code_of("join"),
    message:
        "Joining the grasps of {wildcards.gripper} on {wildcards.dataset}"


use rule join as join_sampling with:
    input:
        tables=parts("results/{dataset}/parts/sampling-{gripper}-{shard}.parquet"),
    output:
        joined=ensure("results/{dataset}/grasps/{gripper}.sampling.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_sampling/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/join_sampling/{gripper}.tsv"
    params:
        by=["label"],
        code=code_of("join"),
    message:
        "Joining the sampling statistics of {wildcards.gripper} on {wildcards.dataset}"


use rule join as join_ungraspable with:
    input:
        tables=parts("results/{dataset}/parts/ungraspable-{gripper}-{shard}.parquet"),
    output:
        joined=ensure("results/{dataset}/grasps/{gripper}.rejected.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_ungraspable/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/join_ungraspable/{gripper}.tsv"
    params:
        by=["id", "stage"],
        code=code_of("join"),
    message:
        "Joining the objects of {wildcards.dataset} without grasps of {wildcards.gripper}"
