"""Select-eval: the evaluation set: one object per cell of a coarse grid, or all own meshes.

Inputs: results/D/objects.parquet, and the shards of postprocess for their Reeb graphs.
Outputs: results/D/eval49.parquet, and eval49.rejected.parquet for objects that were not chosen.
"""

from egad.evalset import EvalSelection


rule select_eval:
    """Choose the most dissimilar objects, or take those that the user wants."""
    input:
        objects="results/{dataset}/objects.parquet",
        solids=parts("results/{dataset}/parts/solids-{shard}.parquet"),
        labels=given_labels,
    output:
        out=ensure("results/{dataset}/eval49.parquet", non_empty=True),
        rejected=ensure("results/{dataset}/eval49.rejected.parquet", non_empty=True),
    log:
        "logs/{dataset}/select_eval.log",
    benchmark:
        "benchmarks/{dataset}/select_eval.tsv"
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=2000, mb_per_thread=250, minutes=30),
    params:
        settings=lambda wildcards: plain(
            select(SETTINGS, EvalSelection, gripper_of_prints(wildcards))
        ),
        selection=selection,
        own=lambda wildcards: SETTINGS.datasets[wildcards.dataset].source == "meshes",
        code=code_of("select_eval"),
    message:
        "Choosing the evaluation set of {wildcards.dataset}"
    script:
        "../scripts/select_eval.py"
