"""Simulated-difficulty: how often the simulated grasps of each object hold.

Inputs: results/D/grasps/G.parquet, with simulated labels.
Outputs: results/D/simulated/G.parquet, one row per object; made if targets.simulated_labels is true.
"""


localrules:
    simulated_difficulty,


rule simulated_difficulty:
    """Summarize the simulated labels of each object."""
    input:
        grasps="results/{dataset}/grasps/{gripper}.parquet",
    output:
        out=ensure("results/{dataset}/simulated/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/simulated_difficulty/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/simulated_difficulty/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=10),
    params:
        code=code_of("simulated_difficulty"),
    message:
        "Summarizing simulated labels of {wildcards.gripper} on {wildcards.dataset}"
    script:
        "../scripts/simulated_difficulty.py"
