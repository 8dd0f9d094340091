"""Release: a dataset that anyone can host, made by the target `release`.

Inputs: results/D/objects.parquet, results/D/eval49.parquet, results/D/ancestry.parquet,
results/D/meshes, results/D/rescaled/G, results/D/convex_parts/G.parquet and the simulated grasps of
all shards, for the dataset and the gripper of the section `release`.
Outputs: results/release, a folder with tables, meshes, pictures, archives for simulators, a gallery,
a dataset card and checksums.
Steps: tables, meshes, pictures and archives; the gallery (gallery.smk); then files that explain
them.
"""

from egad.sim import SimulationBundle
from egad.exchange.release import ReleaseCard, ReleaseTables


localrules:
    release_card,


rule release_tables:
    """Write the tables of the release."""
    input:
        again_if_incomplete("results/release/data"),
        objects=of_release("results/{dataset}/objects.parquet"),
        scales=of_release("results/{dataset}/rescaled/{gripper}/scales.parquet"),
        evaluation=of_release("results/{dataset}/eval49.parquet"),
        grasps=of_release(
            "results/{dataset}/parts/simulated-{gripper}-{shard}.parquet", shard=SHARDS
        ),
        ancestry=ancestry_of_release,
    output:
        out=directory("results/release/data"),
    log:
        "logs/release/release_tables.log",
    benchmark:
        "benchmarks/release/release_tables.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=2000, minutes=10),
    params:
        settings=settings_of(ReleaseTables),
        contents=contents_of(ancestry_of_release),
        code=code_of("release_tables"),
    message:
        "Writing the tables of the release"
    script:
        "../scripts/release_tables.py"


rule release_meshes:
    """Write the meshes of the release."""
    input:
        again_if_incomplete("results/release/meshes"),
        objects=of_release("results/{dataset}/objects.parquet"),
        meshes=of_release("results/{dataset}/meshes"),
    output:
        out=directory("results/release/meshes"),
    log:
        "logs/release/release_meshes.log",
    benchmark:
        "benchmarks/release/release_meshes.tsv"
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=1000, mb_per_thread=300, minutes=20),
    params:
        code=code_of("release_meshes"),
    message:
        "Writing the meshes of the release"
    script:
        "../scripts/release_meshes.py"


rule release_previews:
    """Draw the objects of the release."""
    input:
        again_if_incomplete("results/release/previews"),
        objects=of_release("results/{dataset}/objects.parquet"),
        meshes=of_release("results/{dataset}/meshes"),
    output:
        out=directory("results/release/previews"),
    log:
        "logs/release/release_previews.log",
    benchmark:
        "benchmarks/release/release_previews.tsv"
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=1000, mb_per_thread=300, minutes=30),
    params:
        code=code_of("release_previews"),
    message:
        "Drawing the objects of the release"
    script:
        "../scripts/release_previews.py"


rule release_archive:
    """Write the objects of the release for simulators, in one format."""
    input:
        scales=of_release("results/{dataset}/rescaled/{gripper}/scales.parquet"),
        convex_parts=of_release("results/{dataset}/convex_parts/{gripper}.parquet"),
    output:
        out=ensure("results/release/archives/{format}.zip", non_empty=True),
    log:
        "logs/release/release_archive/{format}.log",
    benchmark:
        "benchmarks/release/release_archive/{format}.tsv"
    wildcard_constraints:
        format="|".join(SETTINGS.release.archives) or "(?!)",
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1500, minutes=60),
    params:
        settings=settings_of(SimulationBundle),
        format_name="{format}",
        meshes=subpath(input.scales, parent=True),
        code=code_of_format("release_archive"),
    message:
        "Writing the objects of the release as {wildcards.format}"
    script:
        "../scripts/release_archive.py"


rule release_card:
    """Write the dataset card, licence, citation, provenance and checksums of the release."""
    input:
        pieces=[f"results/release/{name}" for name in ("data", "meshes", "previews")],
        archives=archives_of_release,
        gallery=["results/release/index.html", "results/release/gallery"],
    output:
        card=ensure("results/release/README.md", non_empty=True),
        citation=ensure("results/release/CITATION.cff", non_empty=True),
        licence=ensure("results/release/LICENSE", non_empty=True),
        provenance=ensure("results/release/provenance.json", non_empty=True),
        sums=ensure("results/release/SHA256SUMS", non_empty=True),
        networks=directory("results/release/networks"),
    log:
        "logs/release/release_card.log",
    benchmark:
        "benchmarks/release/release_card.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, minutes=10),
    params:
        settings=settings_of(ReleaseCard),
        out=subpath(output.card, parent=True),
        networks=contents_of(shipped_networks),
        code=code_of("release_card"),
    message:
        "Describing the release"
    script:
        "../scripts/release_card.py"
