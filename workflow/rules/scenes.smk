"""Scenes: packed and piled objects of a dataset, depth images of them, and labelled grasps.

Inputs: results/D/objects.parquet, results/D/rescaled/G, results/D/convex_parts/G.parquet; the
held-out evaluation set results/D/eval49.parquet, and the ancestors of the objects, if known.
Outputs: results/D/scenes/G/scenes-N.parquet and grasps-N.parquet; card.md and scene.png, their
description; rejected.parquet, the objects in no scene. Made if targets.scenes is true.
Steps: shards of scenes are made (their number depends on that of the scenes); then the card.
"""

from egad.learning.scenes import MakeScenes
from egad.learning.scenes import SceneParameters


localrules:
    scene_card,


rule scenes:
    """Make the scenes of a shard."""
    input:
        objects="results/{dataset}/objects.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
        convex_parts="results/{dataset}/convex_parts/{gripper}.parquet",
        evaluation=get_held_out_input("scenes"),
        ancestry=known_ancestry,
        hand=gripper_files,
    output:
        out=ensure("results/{dataset}/scenes/{gripper}/scenes-{shard}.parquet", non_empty=True),
        grasps=ensure("results/{dataset}/scenes/{gripper}/grasps-{shard}.parquet", non_empty=True),
    log:
        "logs/{dataset}/scenes/{gripper}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/scenes/{gripper}-{shard}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=60),
    params:
        settings=settings_of(MakeScenes),
        meshes=subpath(input.scales, parent=True),
        shard=shard_of(len(SCENE_SHARDS)),
        code=code_of("scenes"),
        contents=contents_of(gripper_files),
    message:
        "Making scenes of {wildcards.dataset} for {wildcards.gripper}, shard {wildcards.shard}"
    script:
        "../scripts/scenes.py"


rule scene_card:
    """Describe the scenes of a gripper."""
    input:
        parts=parts("results/{dataset}/scenes/{gripper}/scenes-{shard}.parquet", SCENE_SHARDS),
        grasps=parts("results/{dataset}/scenes/{gripper}/grasps-{shard}.parquet", SCENE_SHARDS),
        objects="results/{dataset}/objects.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
        convex_parts="results/{dataset}/convex_parts/{gripper}.parquet",
        evaluation=get_held_out_input("scenes"),
        ancestry=known_ancestry,
    output:
        out=ensure("results/{dataset}/scenes/{gripper}/card.md", non_empty=True),
        picture=ensure("results/{dataset}/scenes/{gripper}/scene.png", non_empty=True),
        rejected=ensure("results/{dataset}/scenes/{gripper}/rejected.parquet", non_empty=True),
    log:
        "logs/{dataset}/scene_card/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/scene_card/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, minutes=10),
    params:
        settings=settings_of(SceneParameters),
        folder=subpath(output.out, parent=True),
        shards=len(SCENE_SHARDS),
        code=code_of("scene_card"),
    message:
        "Describing the scenes of {wildcards.dataset} for {wildcards.gripper}"
    script:
        "../scripts/scene_card.py"
