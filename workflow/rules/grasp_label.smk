"""Grasp-label: antipodal grasps with plain and robust quality.

Inputs: results/D/objects.parquet, results/D/rescaled/G.
Outputs: results/D/grasps/G.parquet; G.tally.parquet, what became of the candidates of each object;
G.rejected.parquet, the objects without any grasp.
Steps: shards of objects are labelled; then the tables of the shards are joined.
"""


localrules:
    join_tallies,
    join_ungraspable,


rule grasp_label:
    """Label the grasps of the objects of a shard."""
    input:
        objects="results/{dataset}/objects.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
        mesh=gripper_mesh,
    output:
        grasps=ensure("results/{dataset}/parts/grasps-{gripper}-{shard}.parquet", non_empty=True),
        tally=ensure("results/{dataset}/parts/tally-{gripper}-{shard}.parquet", non_empty=True),
        rejected=ensure(
            "results/{dataset}/parts/ungraspable-{gripper}-{shard}.parquet",
            non_empty=True,
        ),
    log:
        "logs/{dataset}/grasp_label/{gripper}-{shard}.log",
    benchmark:
        "benchmarks/{dataset}/grasp_label/{gripper}-{shard}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs("grasp_label"),
    params:
        settings=settings_of("LabelParameters"),
        meshes=subpath(input.scales, parent=True),
        shards=len(SHARDS),
        contents=contents_of(gripper_mesh),
        code=code_version("egad.pipeline.stages.grasp_label"),
    message:
        "Labelling grasps of {wildcards.gripper} on {wildcards.dataset}, shard {wildcards.shard}"
    shell:
        "egad grasp-label --settings {params.settings:q} --shard {wildcards.shard}"
        " --shards {params.shards} --objects {input.objects:q} --meshes {params.meshes:q}"
        " --out {output.grasps:q} --tally {output.tally:q} --rejected {output.rejected:q}"
        " > {log:q} 2>&1"


rule join_grasps:
    """All labelled grasps of a gripper."""
    input:
        parts("results/{dataset}/parts/grasps-{gripper}-{shard}.parquet"),
    output:
        ensure("results/{dataset}/grasps/{gripper}.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_grasps/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/join_grasps/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs("join_grasps"),
    params:
        code=code_version("egad.pipeline.stages.join"),
    message:
        "Joining the grasps of {wildcards.gripper} on {wildcards.dataset}"
    shell:
        "egad join --by label --by grasp --out {output:q} {input:q} > {log:q} 2>&1"


rule join_tallies:
    """What became of the candidates of every object."""
    input:
        parts("results/{dataset}/parts/tally-{gripper}-{shard}.parquet"),
    output:
        ensure("results/{dataset}/grasps/{gripper}.tally.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_tallies/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/join_tallies/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs("join_tallies"),
    params:
        code=code_version("egad.pipeline.stages.join"),
    message:
        "Joining the tallies of {wildcards.gripper} on {wildcards.dataset}"
    shell:
        "egad join --by label --out {output:q} {input:q} > {log:q} 2>&1"


rule join_ungraspable:
    """The objects that a gripper has no grasp for."""
    input:
        parts("results/{dataset}/parts/ungraspable-{gripper}-{shard}.parquet"),
    output:
        ensure("results/{dataset}/grasps/{gripper}.rejected.parquet", non_empty=True),
    log:
        "logs/{dataset}/join_ungraspable/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/join_ungraspable/{gripper}.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs("join_ungraspable"),
    params:
        code=code_version("egad.pipeline.stages.join"),
    message:
        "Joining the objects of {wildcards.dataset} without grasps of {wildcards.gripper}"
    shell:
        "egad join --by id --by stage --out {output:q} {input:q} > {log:q} 2>&1"
