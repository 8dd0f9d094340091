"""Rescale: objects scaled to a gripper.

Inputs: results/D/meshes.
Outputs: results/D/rescaled/G/LABEL.obj (metres), scales.parquet and rejected.parquet.
"""

from egad.exchange import RescaleMeshes


rule rescale:
    """Scale all objects of a dataset to one gripper."""
    input:
        again_if_incomplete("results/{dataset}/rescaled/{gripper}/scales.parquet"),
        meshes="results/{dataset}/meshes",
    output:
        scales=ensure("results/{dataset}/rescaled/{gripper}/scales.parquet", non_empty=True),
        rejected=ensure("results/{dataset}/rescaled/{gripper}/rejected.parquet", non_empty=True),
    log:
        "logs/{dataset}/rescale/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/rescale/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=1000, mb_per_thread=300, minutes=30),
    params:
        settings=settings_of(RescaleMeshes),
        out=subpath(output.scales, parent=True),
        code=code_of("rescale"),
    message:
        "Scaling {wildcards.dataset} to {wildcards.gripper}"
    script:
        "../scripts/rescale.py"
