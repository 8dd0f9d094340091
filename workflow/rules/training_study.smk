"""Training-study: networks trained on different object sets. Made only if named.

Inputs: results/D/objects.parquet, results/D/rescaled/G, results/D/eval49.parquet and, as for render,
results/D/convex_parts/G.parquet of the datasets of the training sets; also results/D/bundle/G of
those of the tests; for the first target gripper G.
Outputs: results/training_study/report.html, results.parquet and clutter.parquet; also images/SET, as
from render, networks/SET/SEED, as from `egad train`, trials/D/NOISE and clutter/D, as from
simulated_trial and clutter. See docs/training.md.
Steps: the images of each set are rendered; a network is trained on them for each seed; it is tested
as the detector SET-SEED with single objects and in clutter; then the report.
"""


localrules:
    set_card,


use rule render as render_set with:
    input:
        objects=of_set("objects.parquet"),
        scales=of_set(f"rescaled/{GRIPPER}/scales.parquet"),
        evaluation=held_out_of_set,
        convex_parts=convex_parts_of_set,
        hand=gripper_files,
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
        shards=count_shards_of_set,
        evaluation=each("--eval", "evaluation"),
        convex_parts=each("--convex-parts", "convex_parts"),
        code=code_of("render"),
    message:
        "Rendering the training set {wildcards.training_set}, shard {wildcards.shard}"


use rule image_card as set_card with:
    input:
        images=all_shards_of_set(
            "results/training_study/images/{training_set}/images-{shard}.parquet"
        ),
        rejects=all_shards_of_set(
            "results/training_study/parts/unrendered-{training_set}-{shard}.parquet"
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
        shards=count_shards_of_set,
        rejects=each("--rejects", "rejects"),
        code=code_of("image_card"),
    message:
        "Describing the images of the training set {wildcards.training_set}"


rule train_network:
    """Train a network on the images of a set; training resumes from its last checkpoint."""
    input:
        images_of_set,
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
        images=lambda wildcards, input: [str(Path(card).parent) for card in input],
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


use rule simulated_trial as study_trial with:
    input:
        evaluation="results/{dataset}/eval49.parquet",
        bundle=f"results/{{dataset}}/bundle/{GRIPPER}/bundle.parquet",
        grasps=labelled,
        weights=weights_of_detector,
        hand=gripper_files,
    output:
        ensure("results/training_study/trials/{dataset}/{noise}/{detector}.parquet", non_empty=True),
    log:
        "logs/training_study/study_trial/{dataset}-{noise}-{detector}.log",
    benchmark:
        "benchmarks/training_study/study_trial/{dataset}-{noise}-{detector}.tsv"
    params:
        settings=settings_of_test("simulate"),
        given=settings_of_test_with_keep_going("simulate"),
        bundle=subpath(input.bundle, parent=True),
        shard=0,
        shards=1,
        grasps=each("--grasps", "grasps"),
        code=code_of("simulate"),
        contents=contents_of(gripper_files),
        detector=detector_code,
    message:
        "Running trials of {wildcards.detector} on {wildcards.dataset}, noise {wildcards.noise}"


use rule clutter as study_clutter with:
    input:
        bundle=f"results/{{dataset}}/bundle/{GRIPPER}/bundle.parquet",
        grasps=labelled,
        weights=weights_of_detector,
        hand=gripper_files,
    output:
        ensure("results/training_study/clutter/{dataset}/{detector}.parquet", non_empty=True),
    log:
        "logs/training_study/study_clutter/{dataset}-{detector}.log",
    benchmark:
        "benchmarks/training_study/study_clutter/{dataset}-{detector}.tsv"
    params:
        settings=settings_of_test("clutter"),
        given=settings_of_test_with_keep_going("clutter"),
        bundle=subpath(input.bundle, parent=True),
        shard=0,
        shards=1,
        grasps=each("--grasps", "grasps"),
        code=code_of("clutter"),
        contents=contents_of(gripper_files),
        detector=detector_code,
    message:
        "Clearing tables with {wildcards.detector} on {wildcards.dataset}"


rule training_study:
    """Compare all networks."""
    input:
        compared,
    output:
        page=ensure("results/training_study/report.html", non_empty=True),
        table=ensure("results/training_study/results.parquet", non_empty=True),
        clutter=ensure("results/training_study/clutter.parquet", non_empty=True),
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
        " --clutter {output.clutter:q} {input:q} > {log:q} 2>&1"
