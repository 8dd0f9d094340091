"""Bundle: the evaluation set for simulators; the trials use it.

Inputs: results/D/eval49.parquet, results/D/rescaled/G.
Outputs: results/D/bundle/G, a folder with bundle.parquet and rejected.parquet.
"""

from egad.sim import SimulationBundle


rule bundle:
    """Write convex parts, descriptions and poses at rest, for one gripper."""
    input:
        again_if_incomplete("results/{dataset}/bundle/{gripper}/bundle.parquet"),
        evaluation="results/{dataset}/eval49.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
    output:
        table=ensure("results/{dataset}/bundle/{gripper}/bundle.parquet", non_empty=True),
        rejected=ensure("results/{dataset}/bundle/{gripper}/rejected.parquet", non_empty=True),
    log:
        "logs/{dataset}/bundle/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/bundle/{gripper}.tsv"
    # Runs on all cores, before the trials, which run on one core each.
    priority: 2
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=1500, mb_per_thread=500, minutes=60),
    params:
        settings=settings_of(SimulationBundle),
        meshes=subpath(input.scales, parent=True),
        out=subpath(output.table, parent=True),
        code=code_of("bundle"),
    message:
        "Writing the simulation bundle of {wildcards.dataset} for {wildcards.gripper}"
    script:
        "../scripts/bundle.py"
