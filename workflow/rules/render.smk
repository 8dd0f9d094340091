"""Render: depth images of the objects at rest, with their reachable grasps.

Inputs: results/D/objects.parquet, results/D/rescaled/G, and the held-out evaluation set
results/D/eval49.parquet; for scenes of several objects, and to simulate grasps, also
results/D/convex_parts/G.parquet.
Outputs: results/D/images/G/images-N.parquet; card.md and openings.svg, their description;
rejected.parquet, the objects without images. Made if targets.render is true.
Steps: shards of images are rendered (their number depends on that of the images); then the card.
"""

from egad.learning.images import RenderImages
from egad.learning.images import RenderParameters


localrules:
    image_card,


rule render:
    """Render the images of a shard."""
    input:
        objects="results/{dataset}/objects.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
        evaluation=get_held_out_input("render"),
        convex_parts=only_if(
            SETTINGS.render.needs_convex_parts, "results/{dataset}/convex_parts/{gripper}.parquet"
        ),
        hand=gripper_files,
    output:
        out=ensure("results/{dataset}/images/{gripper}/images-{shard}.parquet", non_empty=True),
        rejected=ensure(
            "results/{dataset}/parts/unrendered-{gripper}-{shard}.parquet",
            non_empty=True,
        ),
    log:
        "logs/{dataset}/render/{gripper}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/render/{gripper}-{shard}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=30),
    params:
        settings=settings_of(RenderImages),
        meshes=subpath(input.scales, parent=True),
        shard=shard_of(len(IMAGE_SHARDS)),
        code=code_of("render"),
    message:
        "Rendering {wildcards.dataset} for {wildcards.gripper}, shard {wildcards.shard}"
    script:
        "../scripts/render.py"


rule image_card:
    """Describe the images of a gripper."""
    input:
        parts=parts("results/{dataset}/images/{gripper}/images-{shard}.parquet", IMAGE_SHARDS),
        rejects=parts("results/{dataset}/parts/unrendered-{gripper}-{shard}.parquet", IMAGE_SHARDS),
    output:
        out=ensure("results/{dataset}/images/{gripper}/card.md", non_empty=True),
        figure=report(
            ensure("results/{dataset}/images/{gripper}/openings.svg", non_empty=True),
            caption="../report/openings.rst",
            category="Images",
            labels={"dataset": "{dataset}", "gripper": "{gripper}"},
        ),
        rejected=ensure("results/{dataset}/images/{gripper}/rejected.parquet", non_empty=True),
    log:
        "logs/{dataset}/image_card/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/image_card/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, minutes=10),
    params:
        settings=settings_of(RenderParameters),
        images=subpath(output.out, parent=True),
        shards=len(IMAGE_SHARDS),
        code=code_of("image_card"),
    message:
        "Describing the images of {wildcards.dataset} for {wildcards.gripper}"
    script:
        "../scripts/image_card.py"
