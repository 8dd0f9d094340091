"""Simulated graspability: how often the simulated grasps of each object hold.

Inputs: results/D/grasps/G.parquet, with simulated labels.
Outputs: results/D/simulated/G.parquet, one row per object; made if targets.simulated_labels is true.
"""


localrules:
    simulated_graspability,


rule simulated_graspability:
    """Summarize the simulated labels of each object."""
    input:
        grasps="results/{dataset}/grasps/{gripper}.parquet",
    output:
        out=ensure("results/{dataset}/simulated/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/simulated_graspability/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/simulated_graspability/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=10),
    params:
        code=code_of("simulated_graspability"),
    message:
        "Summarizing simulated labels of {wildcards.gripper} on {wildcards.dataset}"
    script:
        "../scripts/simulated_graspability.py"
