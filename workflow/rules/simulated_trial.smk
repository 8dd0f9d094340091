"""Simulated-trial: attempts of a grasp detector on the evaluation set.

Inputs: results/D/eval49.parquet, results/D/bundle/G; for the detector `labels` also
results/D/grasps/G.parquet, for `grasps:` its files; its weights, if a workflow makes them.
Outputs: results/D/trials/G/P.parquet, one row per attempt.
Steps: trials on shards of objects; then the tables of the shards are joined.
"""

from egad.bench import SimulatedTrials


localrules:
    join_trials,


rule simulated_trial:
    """Run trials on the objects of a shard."""
    input:
        evaluation="results/{dataset}/eval49.parquet",
        table="results/{dataset}/bundle/{gripper}/bundle.parquet",
        grasps=labelled,
        weights=weights_of_detector,
        hand=gripper_files,
    output:
        out=ensure(
            "results/{dataset}/parts/trials-{gripper}-{detector}-{shard}.parquet",
            non_empty=True,
        ),
    log:
        "logs/{dataset}/simulated_trial/{gripper}-{detector}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/simulated_trial/{gripper}-{detector}-{shard}.tsv"
    # Start these jobs first: some take five times as long as others.
    priority: 1
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=120),
    params:
        settings=settings_of(SimulatedTrials),
        keep_going=keep_going,
        bundle=subpath(input.table, parent=True),
        shard=shard_of(len(EVALUATION_SHARDS)),
        code=code_of("simulate"),
        contents=contents_of(gripper_files, labelled),
        detector=detector_code,
    message:
        "Running trials of {wildcards.detector} with {wildcards.gripper} on {wildcards.dataset}, shard {wildcards.shard}"
    script:
        "../scripts/simulate.py"


use rule join as join_trials with:
    input:
        tables=parts(
            "results/{dataset}/parts/trials-{gripper}-{detector}-{shard}.parquet",
            EVALUATION_SHARDS,
        ),
    output:
        joined=ensure("results/{dataset}/trials/{gripper}/{detector}.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_trials/{gripper}-{detector}.log",
    benchmark:
        "benchmarks/{dataset}/join_trials/{gripper}-{detector}.tsv"
    params:
        by=["label", "attempt"],
        code=code_of("join"),
    message:
        "Joining the trials of {wildcards.detector} with {wildcards.gripper} on {wildcards.dataset}"
