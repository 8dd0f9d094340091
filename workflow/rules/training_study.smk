"""Training-study: networks trained on different object sets. Made only if named.

Inputs: results/D/objects.parquet, results/D/rescaled/G and results/D/eval49.parquet of the datasets of the training sets, for the first target gripper G.
Outputs: results/training_study/report.html and results.parquet; also images/SET, as from render, and
networks/SET/SEED, as from `egad train`. See docs/training-study.md.
Steps: the images of each set are rendered; a network is trained on them for each seed; the rules
simulated_trial and join_trials run its trials as the detector SET-SEED; then the report.
"""


localrules:
    set_card,


use rule render as render_set with:
    input:
        objects=of_set("objects.parquet"),
        scales=of_set(f"rescaled/{GRIPPER}/scales.parquet"),
        evaluation=held_out_of_set,
        convex_parts=parts_of_set,
        hand=files_of_the_gripper,
    output:
        images=ensure(
            "results/training_study/images/{training_set}/images-{shard}.parquet", non_empty=True
        ),
        rejected=ensure(
            "results/training_study/parts/unrendered-{training_set}-{shard}.parquet",
            non_empty=True,
        ),
    log:
        "logs/training_study/render_set/{training_set}-{shard}.log",
    benchmark:
        "benchmarks/training_study/render_set/{training_set}-{shard}.tsv"
    params:
        settings=settings_of_set("render"),
        meshes=subpath(input.scales, parent=True),
        shards=len(IMAGE_SHARDS),
        evaluation=each("--eval", "evaluation"),
        convex_parts=each("--convex-parts", "convex_parts"),
        code=code_of("render"),
    message:
        "Rendering the training set {wildcards.training_set}, shard {wildcards.shard}"


use rule image_card as set_card with:
    input:
        images=parts(
            "results/training_study/images/{training_set}/images-{shard}.parquet", IMAGE_SHARDS
        ),
        rejects=parts(
            "results/training_study/parts/unrendered-{training_set}-{shard}.parquet", IMAGE_SHARDS
        ),
    output:
        card=ensure("results/training_study/images/{training_set}/card.md", non_empty=True),
        figure=ensure("results/training_study/images/{training_set}/openings.svg", non_empty=True),
        rejected=ensure(
            "results/training_study/images/{training_set}/rejected.parquet", non_empty=True
        ),
    log:
        "logs/training_study/set_card/{training_set}.log",
    benchmark:
        "benchmarks/training_study/set_card/{training_set}.tsv"
    params:
        settings=settings_of_set("image_card"),
        dataset=lambda wildcards: SETTINGS.training_sets[wildcards.training_set].dataset,
        gripper=GRIPPER,
        folder=subpath(output.card, parent=True),
        shards=len(IMAGE_SHARDS),
        rejects=each("--rejects", "rejects"),
        code=code_of("image_card"),
    message:
        "Describing the images of the training set {wildcards.training_set}"


rule train_network:
    """Train a network on the images of a set; training resumes from its last checkpoint."""
    input:
        card="results/training_study/images/{training_set}/card.md",
    output:
        weights="results/training_study/networks/{training_set}/{seed}/weights.safetensors",
        history="results/training_study/networks/{training_set}/{seed}/history.parquet",
        score="results/training_study/networks/{training_set}/{seed}/score.parquet",
        chart="results/training_study/networks/{training_set}/{seed}/history.svg",
        card="results/training_study/networks/{training_set}/{seed}/README.md",
    log:
        "logs/training_study/train_network/{training_set}-{seed}.log",
    benchmark:
        "benchmarks/training_study/train_network/{training_set}-{seed}.tsv"
    # The longest jobs; trials need them.
    priority: 2
    conda:
        ENVIRONMENT
    threads: 2
    resources:
        **needs(mb=2000, mb_per_thread=500, minutes=60),
    params:
        settings=settings_of_set("train"),
        images=subpath(input.card, parent=True),
        folder=subpath(output.weights, parent=True),
        # The chart and the card of a network do not affect it.
        code=[
            code_version(f"egad.learning.{name}") for name in ("training", "weights", "evaluation")
        ],
    message:
        "Training network {wildcards.seed} on the training set {wildcards.training_set}"
    shell:
        "egad train --settings {params.settings:q} --out {params.folder:q} --jobs {threads}"
        " {params.images:q} > {log:q} 2>&1"


rule training_study:
    """Compare all networks."""
    input:
        compared,
    output:
        page=ensure("results/training_study/report.html", non_empty=True),
        table=ensure("results/training_study/results.parquet", non_empty=True),
    log:
        "logs/training_study/training_study.log",
    benchmark:
        "benchmarks/training_study/training_study.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=30),
    params:
        settings=settings_of("training_study"),
        gripper=GRIPPER,
        results=subpath(output.page, ancestor=2),
        code=code_of("training_study"),
    message:
        "Comparing the networks of all training sets"
    shell:
        "egad training-study --settings {params.settings:q} --gripper {params.gripper:q}"
        " --results {params.results:q} --out {output.page:q} --table {output.table:q}"
        " {input:q} > {log:q} 2>&1"
