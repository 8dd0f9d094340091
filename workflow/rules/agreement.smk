"""Agreement: labelled grasps of the evaluation set, executed in simulation.

Inputs: results/D/eval49.parquet, results/D/bundle/G, results/D/grasps/G.parquet.
Outputs: results/D/agreement/G.parquet, one row per grasp; made if targets.agreement is true.
Steps: labelled grasps are executed in shards of objects; then the tables are joined.
"""

from egad.sim import LabelTrialParameters


localrules:
    join_agreement,


rule agreement:
    """Execute labelled grasps of the objects of a shard."""
    input:
        evaluation="results/{dataset}/eval49.parquet",
        table="results/{dataset}/bundle/{gripper}/bundle.parquet",
        grasps="results/{dataset}/grasps/{gripper}.parquet",
    output:
        out=ensure(
            "results/{dataset}/parts/agreement-{gripper}-{shard}.parquet",
            non_empty=True,
        ),
    log:
        "logs/{dataset}/agreement/{gripper}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/agreement/{gripper}-{shard}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=60),
    params:
        settings=settings_of(LabelTrialParameters),
        bundle=subpath(input.table, parent=True),
        shard=shard_of(len(EVALUATION_SHARDS)),
        code=code_of("agreement"),
    message:
        "Executing grasps of {wildcards.gripper} on {wildcards.dataset}, shard {wildcards.shard}"
    script:
        "../scripts/agreement.py"


use rule join as join_agreement with:
    input:
        tables=parts(
            "results/{dataset}/parts/agreement-{gripper}-{shard}.parquet", EVALUATION_SHARDS
        ),
    output:
        joined=ensure("results/{dataset}/agreement/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_agreement/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/join_agreement/{gripper}.tsv"
    params:
        by=["label", "grasp"],
        code=code_of("join"),
    message:
        "Joining the executed grasps of {wildcards.gripper} on {wildcards.dataset}"
