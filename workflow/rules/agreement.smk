"""Agreement: labelled grasps of the evaluation set, executed in simulation.

Inputs: results/D/eval49.parquet, results/D/bundle/G, results/D/grasps/G.parquet.
Outputs: results/D/agreement/G.parquet, one row per grasp; made if targets.agreement is true.
Steps: labelled grasps of shards of objects are executed; then the tables are joined.
"""


localrules:
    join_agreement,


rule agreement:
    """Execute labelled grasps of the objects of a shard."""
    input:
        evaluation="results/{dataset}/eval49.parquet",
        bundle="results/{dataset}/bundle/{gripper}/bundle.parquet",
        grasps="results/{dataset}/grasps/{gripper}.parquet",
    output:
        ensure(
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
        settings=settings_of("agreement"),
        bundle=subpath(input.bundle, parent=True),
        shards=len(EVALUATION_SHARDS),
        code=code_of("agreement"),
    message:
        "Executing grasps of {wildcards.gripper} on {wildcards.dataset}, shard {wildcards.shard}"
    shell:
        "egad agreement --settings {params.settings:q}"
        " --shard {wildcards.shard} --shards {params.shards} --eval {input.evaluation:q}"
        " --bundle {params.bundle:q} --grasps {input.grasps:q} --out {output:q} > {log:q} 2>&1"


use rule join as join_agreement with:
    input:
        parts("results/{dataset}/parts/agreement-{gripper}-{shard}.parquet", EVALUATION_SHARDS),
    output:
        ensure("results/{dataset}/agreement/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_agreement/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/join_agreement/{gripper}.tsv"
    params:
        by=["--by", "label", "--by", "grasp"],
        code=code_of("join"),
    message:
        "Joining the executed grasps of {wildcards.gripper} on {wildcards.dataset}"
