"""Size-effect: grasp quality over size for three objects of the evaluation set.

Inputs: results/D/eval49.parquet, results/D/meshes.
Outputs: results/D/size_effect/G.parquet.
"""

from egad.measures import SizeEffectParameters


rule size_effect:
    """Compute grasp quality over size for an easy, a medium and a hard object."""
    input:
        evaluation="results/{dataset}/eval49.parquet",
        meshes="results/{dataset}/meshes",
    output:
        size_effect=ensure("results/{dataset}/size_effect/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/size_effect/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/size_effect/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, minutes=10),
    params:
        settings=settings_of(SizeEffectParameters),
        code=code_of("size_effect"),
    message:
        "Computing grasp quality over size of {wildcards.dataset} for {wildcards.gripper}"
    script:
        "../scripts/size_effect.py"
