"""Clutter: a grasp detector clears tables of several objects of the evaluation set.

Inputs: results/D/bundle/G; for the detector `labels` also results/D/grasps/G.parquet, and for a
network of the training study its weights.
Outputs: results/D/clutter/G/P.parquet, one row per attempt; made for `targets.clutter`.
Steps: rounds in shards; then the tables of the shards are joined.
"""


localrules:
    join_clutter,


rule clutter:
    """Run the rounds of a shard."""
    input:
        bundle="results/{dataset}/bundle/{gripper}/bundle.parquet",
        grasps=labelled,
        weights=weights_of_detector,
        hand=gripper_files,
    output:
        ensure(
            "results/{dataset}/parts/clutter-{gripper}-{detector}-{shard}.parquet",
            non_empty=True,
        ),
    log:
        "logs/{dataset}/clutter/{gripper}-{detector}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/clutter/{gripper}-{detector}-{shard}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=120),
    params:
        settings=settings_of("clutter"),
        given=settings_with_keep_going("clutter"),
        bundle=subpath(input.bundle, parent=True),
        shard="{shard}",
        shards=len(SHARDS),
        grasps=each("--grasps", "grasps"),
        code=code_of("clutter"),
        contents=contents_of(gripper_files),
        detector=detector_code,
    message:
        "Clearing tables with {wildcards.detector} and {wildcards.gripper} on {wildcards.dataset}, shard {wildcards.shard}"
    shell:
        "egad clutter --settings {params.given:q}"
        " --shard {params.shard} --shards {params.shards}"
        " --bundle {params.bundle:q} {params.grasps:q} --out {output:q} > {log:q} 2>&1"


use rule join as join_clutter with:
    input:
        parts("results/{dataset}/parts/clutter-{gripper}-{detector}-{shard}.parquet"),
    output:
        ensure("results/{dataset}/clutter/{gripper}/{detector}.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_clutter/{gripper}-{detector}.log",
    benchmark:
        "benchmarks/{dataset}/join_clutter/{gripper}-{detector}.tsv"
    params:
        by=["--by", "scene", "--by", "noise", "--by", "round", "--by", "attempt"],
        code=code_of("join"),
    message:
        "Joining the cleared tables of {wildcards.detector} with {wildcards.gripper} on {wildcards.dataset}"
