"""Hands: the report card of the grippers of the targets, which try the same objects.

Inputs: results/D/eval49.parquet, results/D/meshes.
Outputs: results/D/hands/card.html, attempts.parquet; made when asked for.
"""

from egad.bench.hands import ComparedHands


rule hands:
    """Let all grippers of the targets try the evaluation set, and write their report card."""
    input:
        evaluation="results/{dataset}/eval49.parquet",
        meshes="results/{dataset}/meshes",
    output:
        card="results/{dataset}/hands/card.html",
        attempts=ensure("results/{dataset}/hands/attempts.parquet", non_empty=True),
    log:
        "logs/{dataset}/hands.log",
    benchmark:
        "benchmarks/{dataset}/hands.tsv"
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=1000, minutes=120, mb_per_thread=1000),
    params:
        settings=settings_of(ComparedHands),
        names=SETTINGS.targets.grippers,
        code=code_of("hands"),
    message:
        "Comparing hands on {wildcards.dataset}"
    script:
        "../scripts/hands.py"
