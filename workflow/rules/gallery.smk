"""Gallery: a page with a map of all objects of a dataset, and a view of each of them.

Inputs: results/D/objects.parquet, results/D/meshes, results/D/rescaled/G, results/D/grasps/G.parquet,
results/D/eval49.parquet and its trials, for the first target dataset and the first target gripper;
of an archive also results/D/archive.parquet and results/D/ancestry.parquet.
Outputs: results/release/index.html, and its data in results/release/gallery.
"""

SHOWN = {"dataset": SETTINGS.targets.datasets[0], "gripper": GRIPPER}


def of_gallery(pattern, **more):
    """The files of the dataset and the gripper of the gallery."""
    return expand(pattern, **SHOWN, **more)


def archive_of_gallery(wildcards):
    """The archive of the objects, if they come from one."""
    return (
        of_gallery("results/{dataset}/archive.parquet")
        if SHOWN["dataset"] in [*EVOLVED, *GIVEN]
        else []
    )


def ancestry_of_gallery(wildcards):
    """The ancestors of the objects, if they are known."""
    if SHOWN["dataset"] in EVOLVED:
        return of_gallery("results/{dataset}/ancestry.parquet")
    return [str(released_ancestry())] if GIVEN.get(SHOWN["dataset"]) == str(released()) else []


def settings_of_gallery(wildcards):
    """The settings that the stage reads, with the gripper of the gallery."""
    return _as_json(select(SETTINGS, settings_type(stage_function("gallery")), GRIPPER))


rule gallery:
    """Write the gallery of a dataset."""
    input:
        objects=of_gallery("results/{dataset}/objects.parquet"),
        meshes=of_gallery("results/{dataset}/meshes"),
        scales=of_gallery("results/{dataset}/rescaled/{gripper}/scales.parquet"),
        grasps=of_gallery("results/{dataset}/grasps/{gripper}.parquet"),
        evaluation=of_gallery("results/{dataset}/eval49.parquet"),
        trials=of_gallery(
            "results/{dataset}/trials/{gripper}/{detector}.parquet",
            detector=SETTINGS.targets.detectors,
        ),
        archive=archive_of_gallery,
        ancestry=ancestry_of_gallery,
        regions=region_meshes,
    output:
        page=ensure("results/release/index.html", non_empty=True),
        data=directory("results/release/gallery"),
    log:
        "logs/release/gallery.log",
    benchmark:
        "benchmarks/release/gallery.tsv"
    conda:
        ENVIRONMENT
    threads: SIDE_BY_SIDE
    resources:
        **needs(mb=2000, mb_per_thread=500, minutes=60),
    params:
        settings=settings_of_gallery,
        gripper=GRIPPER,
        archive=each("--archive", "archive"),
        ancestry=each("--ancestry", "ancestry"),
        trials=lambda wildcards, input: [f"{Path(file).stem}={file}" for file in input.trials],
        contents=contents_of(region_meshes),
        code=code_of("gallery"),
    message:
        "Writing the gallery"
    shell:
        "egad gallery --settings {params.settings:q} --objects {input.objects:q}"
        " --meshes {input.meshes:q} --gripper {params.gripper:q} --scales {input.scales:q}"
        " --grasps {input.grasps:q} --eval {input.evaluation:q} {params.archive:q}"
        " {params.ancestry:q} --out {output.data:q} --page {output.page:q} --jobs {threads}"
        " {params.trials:q} > {log:q} 2>&1"
