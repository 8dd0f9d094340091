"""Gallery: a page of the release with a map of all objects and a view of each of them.

Inputs: results/D/objects.parquet, results/D/meshes, results/D/rescaled/G, the simulated grasps of all
shards and results/D/eval49.parquet, for the dataset and the gripper of the section `release`;
results/D/trials/G/P.parquet, if they are targets; results/D/archive.parquet and
results/D/ancestry.parquet, if the objects have genomes; other files of results/release, for links.
Outputs: results/release/index.html, and its data in results/release/gallery.
"""


rule gallery:
    """Write the gallery of the release."""
    input:
        again_if_incomplete("results/release/gallery"),
        objects=of_release("results/{dataset}/objects.parquet"),
        meshes=of_release("results/{dataset}/meshes"),
        scales=of_release("results/{dataset}/rescaled/{gripper}/scales.parquet"),
        grasps=of_release(
            "results/{dataset}/parts/simulated-{gripper}-{shard}.parquet", shard=SHARDS
        ),
        evaluation=of_release("results/{dataset}/eval49.parquet"),
        trials=lambda wildcards: list(trials_of_release(wildcards).values()),
        archive=archive_of_release,
        ancestry=ancestry_of_release,
        regions=region_meshes,
        pieces=["results/release/data", "results/release/meshes"],
        archives=archives_of_release,
    output:
        page=ensure("results/release/index.html", non_empty=True),
        out=directory("results/release/gallery"),
    log:
        "logs/release/gallery.log",
    benchmark:
        "benchmarks/release/gallery.tsv"
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=2000, mb_per_thread=500, minutes=60),
    params:
        settings=settings_of_gallery,
        gripper=RELEASED["gripper"],
        detectors=lambda wildcards: list(trials_of_release(wildcards)),
        contents=contents_of(
            lambda wildcards: [*region_meshes(wildcards), *ancestry_of_release(wildcards)]
        ),
        code=code_of("gallery"),
    message:
        "Writing the gallery of the release"
    script:
        "../scripts/gallery.py"
