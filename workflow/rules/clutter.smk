"""Clutter: a grasp detector clears tables of several objects of the evaluation set.

Inputs: results/D/bundle/G; for the detector `labels` also results/D/grasps/G.parquet, for
`grasps:` its files; its weights, if a workflow makes them.
Outputs: results/D/clutter/G/P.parquet, one row per attempt; made for `targets.clutter`.
Steps: rounds are run in shards; then the tables of the shards are joined.
"""

from egad.bench import ClearedTables


localrules:
    join_clutter,


rule clutter:
    """Run the rounds of a shard."""
    input:
        table="results/{dataset}/bundle/{gripper}/bundle.parquet",
        grasps=labelled,
        weights=weights_of_detector,
        hand=gripper_files,
    output:
        out=ensure(
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
        settings=settings_of(ClearedTables),
        keep_going=keep_going,
        bundle=subpath(input.table, parent=True),
        shard=shard_of(len(SHARDS)),
        code=code_of("clutter"),
        contents=contents_of(gripper_files, labelled),
        detector=detector_code,
    message:
        "Clearing tables with {wildcards.detector} and {wildcards.gripper} on {wildcards.dataset}, shard {wildcards.shard}"
    script:
        "../scripts/clutter.py"


use rule join as join_clutter with:
    input:
        tables=parts("results/{dataset}/parts/clutter-{gripper}-{detector}-{shard}.parquet"),
    output:
        joined=ensure("results/{dataset}/clutter/{gripper}/{detector}.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_clutter/{gripper}-{detector}.log",
    benchmark:
        "benchmarks/{dataset}/join_clutter/{gripper}-{detector}.tsv"
    params:
        by=["scene", "noise", "round", "attempt"],
        code=code_of("join"),
    message:
        "Joining the cleared tables of {wildcards.detector} with {wildcards.gripper} on {wildcards.dataset}"
