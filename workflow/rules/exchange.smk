"""Exchange: objects, grasps and images in the formats that `targets.exports` names.

Inputs: results/D/objects.parquet, results/D/rescaled/G, results/D/grasps/G.parquet.
For images results/D/images/G; card.md is its last file. For objects of the evaluation set
results/D/bundle/G, for all objects results/D/rescaled/G and results/D/convex_parts/G.parquet.
Outputs: results/D/exchange/G.hdf5 (Dex-Net), results/D/exchange/G-FORMAT (the others).
Steps: for Dex-Net, distance fields and poses of shards of objects; then one file for all of them.
"""

from egad.exchange import DexNetObjects


rule dexnet_objects:
    """Compute distance fields, stable poses and masses of the objects of a shard."""
    input:
        objects="results/{dataset}/objects.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
    output:
        out=ensure("results/{dataset}/parts/exchange-{gripper}-{shard}.hdf5", non_empty=True),
    log:
        "logs/{dataset}/dexnet_objects/{gripper}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/dexnet_objects/{gripper}-{shard}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, minutes=30),
    params:
        settings=settings_of(DexNetObjects),
        meshes=subpath(input.scales, parent=True),
        shard=shard_of(len(SHARDS)),
        code=code_of("dexnet_objects"),
    message:
        "Computing distance fields of {wildcards.dataset} for {wildcards.gripper}, shard {wildcards.shard}"
    script:
        "../scripts/dexnet_objects.py"


rule dexnet:
    """Write the Dex-Net database of a gripper."""
    input:
        objects="results/{dataset}/objects.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
        grasps="results/{dataset}/grasps/{gripper}.parquet",
        parts=parts("results/{dataset}/parts/exchange-{gripper}-{shard}.hdf5"),
    output:
        out=ensure("results/{dataset}/exchange/{gripper}.hdf5", non_empty=True),
    log:
        "logs/{dataset}/dexnet/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/dexnet/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, minutes=30),
    params:
        settings=settings_of_export("dexnet"),
        dataset=subpath(input.objects, parent=True),
        code=code_of("dexnet"),
    message:
        "Writing the Dex-Net database of {wildcards.gripper} on {wildcards.dataset}"
    script:
        "../scripts/dexnet.py"


rule export:
    """Write the objects, grasps or images of a gripper in the format of another program."""
    input:
        again_if_incomplete("results/{dataset}/exchange/{gripper}-{format}"),
        exported_from,
    output:
        out=directory("results/{dataset}/exchange/{gripper}-{format}"),
    log:
        "logs/{dataset}/export/{gripper}-{format}.log",
    benchmark:
        "benchmarks/{dataset}/export/{gripper}-{format}.tsv"
    wildcard_constraints:
        format="|".join(name for name in FORMATS if name != "dexnet"),
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1500, minutes=30),
    params:
        settings=settings_of_export(),
        format_name="{format}",
        chosen=SETTINGS.targets.export_objects,
        dataset="results/{dataset}",
        code=code_of_format("export"),
    message:
        "Writing {wildcards.dataset} for {wildcards.gripper} as {wildcards.format}"
    script:
        "../scripts/export.py"
