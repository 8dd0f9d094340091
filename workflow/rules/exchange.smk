"""Exchange: labelled grasps in the formats of other programs. Made if `targets.exports` asks.

Inputs: results/D/objects.parquet, results/D/rescaled/G, results/D/grasps/G.parquet.
For images results/D/images/G, which results/D/images/G/card.md is the last file of.
Outputs: results/D/exchange/G.hdf5 (Dex-Net), results/D/exchange/G-acronym/LABEL.h5 (ACRONYM),
results/D/exchange/G-LAYOUT (images as Jacquard, Cornell or GQ-CNN have them).
Steps: for Dex-Net, shards of objects get distance fields and poses; then one file takes them all.
"""


rule dexnet_objects:
    """Distance fields, stable poses and masses of the objects of a shard."""
    input:
        objects="results/{dataset}/objects.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
    output:
        ensure("results/{dataset}/parts/exchange-{gripper}-{shard}.hdf5", non_empty=True),
    log:
        "logs/{dataset}/dexnet_objects/{gripper}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/dexnet_objects/{gripper}-{shard}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs("dexnet_objects"),
    params:
        settings=settings_of("DexNetObjects"),
        meshes=subpath(input.scales, parent=True),
        shards=len(SHARDS),
        code=code_version("egad.pipeline.stages.dexnet_objects"),
    message:
        "Distance fields of {wildcards.dataset} for {wildcards.gripper}, shard {wildcards.shard}"
    shell:
        "IGL_NUM_THREADS={threads} egad dexnet-objects --settings {params.settings:q}"
        " --shard {wildcards.shard} --shards {params.shards} --objects {input.objects:q}"
        " --meshes {params.meshes:q} --out {output:q} > {log:q} 2>&1"


rule dexnet:
    """The Dex-Net database of a gripper."""
    input:
        objects="results/{dataset}/objects.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
        grasps="results/{dataset}/grasps/{gripper}.parquet",
        parts=parts("results/{dataset}/parts/exchange-{gripper}-{shard}.hdf5"),
    output:
        ensure("results/{dataset}/exchange/{gripper}.hdf5", non_empty=True),
    log:
        "logs/{dataset}/dexnet/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/dexnet/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs("dexnet"),
    params:
        settings=settings_of("DexNetDatabase"),
        dataset=subpath(input.objects, parent=True),
        parts=each("--part", "parts"),
        code=code_version("egad.pipeline.stages.dexnet"),
    message:
        "Writing the Dex-Net database of {wildcards.gripper} on {wildcards.dataset}"
    shell:
        "egad export --format dexnet --settings {params.settings:q} --gripper {wildcards.gripper:q}"
        " {params.parts:q} --out {output:q} {params.dataset:q} > {log:q} 2>&1"


rule acronym:
    """The ACRONYM files of a gripper."""
    input:
        objects="results/{dataset}/objects.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
        grasps="results/{dataset}/grasps/{gripper}.parquet",
    output:
        directory("results/{dataset}/exchange/{gripper}-acronym"),
    log:
        "logs/{dataset}/acronym/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/acronym/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs("acronym"),
    params:
        settings=settings_of("AcronymFiles"),
        dataset=subpath(input.objects, parent=True),
        code=code_version("egad.pipeline.stages.acronym"),
    message:
        "Writing the ACRONYM files of {wildcards.gripper} on {wildcards.dataset}"
    shell:
        "egad export --format acronym --settings {params.settings:q} --gripper {wildcards.gripper:q}"
        " --out {output:q} {params.dataset:q} > {log:q} 2>&1"


rule image_layout:
    """The rendered images of a gripper in the layout of another dataset."""
    input:
        card="results/{dataset}/images/{gripper}/card.md",
    output:
        directory("results/{dataset}/exchange/{gripper}-{layout}"),
    log:
        "logs/{dataset}/image_layout/{gripper}-{layout}.log",
    benchmark:
        "benchmarks/{dataset}/image_layout/{gripper}-{layout}.tsv"
    wildcard_constraints:
        layout="jacquard|cornell|gqcnn",
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs("image_layout"),
    params:
        settings=settings_of("ImageLayouts"),
        dataset=subpath(input.card, ancestor=3),
        code=code_version("egad.pipeline.stages.image_layout"),
    message:
        "Writing the images of {wildcards.dataset} for {wildcards.gripper} as {wildcards.layout}"
    shell:
        "egad export --format {wildcards.layout} --settings {params.settings:q}"
        " --gripper {wildcards.gripper:q} --out {output:q} {params.dataset:q} > {log:q} 2>&1"
