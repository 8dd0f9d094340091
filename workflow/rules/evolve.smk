"""Evolve: epochs of islands, merged.

Inputs: only the settings.
Outputs: results/D/archive.parquet, the elites; history.parquet, the steps;
ancestry.parquet, the elites and all their ancestors; epochs/, the
intermediate archives.
Steps: every island evolves from the merged archive of the previous epoch; the islands are merged;
the archive of the last epoch, or the source archive of a dataset, is published. More epochs than
before extend a finished run.
"""

from egad.measures import CellsAndDiversities
from egad.evolution import EvolutionParameters


localrules:
    archive,
    ancestry,
    history,


rule evolve:
    """Evolve one island for one epoch."""
    input:
        base=previous_archive,
        regions=region_meshes,
    output:
        archive=ensure(
            "results/{dataset}/epochs/epoch-{epoch}/island-{island}.parquet",
            non_empty=True,
        ),
        history=ensure(
            "results/{dataset}/epochs/epoch-{epoch}/history-{island}.parquet",
            non_empty=True,
        ),
        lineage=ensure(
            "results/{dataset}/epochs/epoch-{epoch}/lineage-{island}.parquet",
            non_empty=True,
        ),
    log:
        "logs/{dataset}/evolve/epoch-{epoch}-island-{island}.log",
    benchmark:
        "benchmarks/{dataset}/evolve/epoch-{epoch}-island-{island}.tsv"
    wildcard_constraints:
        dataset=EVOLVED_DATASET,
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=1200, mb_per_thread=600, minutes=60),
    params:
        settings=settings_of(EvolutionParameters),
        measures=MEASURES,
        contents=contents_of(region_meshes),
        code=code_of("evolve"),
    message:
        "Evolving {wildcards.dataset}, epoch {wildcards.epoch}, island {wildcards.island}"
    script:
        "../scripts/evolve.py"


rule merge:
    """Merge the islands of an epoch into one archive."""
    input:
        islands=expand(
            "results/{{dataset}}/epochs/epoch-{{epoch}}/island-{island}.parquet",
            island=ISLANDS,
        ),
    output:
        archive=ensure("results/{dataset}/epochs/epoch-{epoch}/archive.parquet", non_empty=True),
    log:
        "logs/{dataset}/merge/epoch-{epoch}.log",
    benchmark:
        "benchmarks/{dataset}/merge/epoch-{epoch}.tsv"
    wildcard_constraints:
        dataset=EVOLVED_DATASET,
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=1000, mb_per_thread=100, minutes=10),
    params:
        settings=settings_of(CellsAndDiversities),
        code=code_of("merge"),
    message:
        "Merging the islands of epoch {wildcards.epoch}"
    script:
        "../scripts/merge.py"


rule archive:
    """Publish the archive that the objects are made from."""
    input:
        final=final_archive,
    output:
        archive=ensure("results/{dataset}/archive.parquet", non_empty=True),
    log:
        "logs/{dataset}/archive.log",
    benchmark:
        "benchmarks/{dataset}/archive.tsv"
    wildcard_constraints:
        dataset=ARCHIVED_DATASET,
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, minutes=10),
    params:
        contents=contents_of(final_archive),
        code=code_of("publish"),
    message:
        "Publishing the archive"
    script:
        "../scripts/publish.py"


rule ancestry:
    """Find the ancestors of the elites, back to random genomes."""
    input:
        archive="results/{dataset}/archive.parquet",
        lineages=expand(
            "results/{{dataset}}/epochs/epoch-{epoch}/lineage-{island}.parquet",
            epoch=range(LAST_EPOCH + 1),
            island=ISLANDS,
        ),
    output:
        ancestry=ensure("results/{dataset}/ancestry.parquet", non_empty=True),
    log:
        "logs/{dataset}/ancestry.log",
    benchmark:
        "benchmarks/{dataset}/ancestry.tsv"
    wildcard_constraints:
        dataset=EVOLVED_DATASET,
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, mb_per_thread=1000, minutes=10),
    params:
        code=code_of("ancestry"),
    message:
        "Finding the ancestors of {wildcards.dataset}"
    script:
        "../scripts/ancestry.py"


use rule join as history with:
    input:
        tables=expand(
            "results/{{dataset}}/epochs/epoch-{epoch}/history-{island}.parquet",
            epoch=range(LAST_EPOCH + 1),
            island=ISLANDS,
        ),
    output:
        joined=ensure("results/{dataset}/history.parquet", non_empty=True),
    log:
        "logs/{dataset}/history.log",
    benchmark:
        "benchmarks/{dataset}/history.tsv"
    wildcard_constraints:
        dataset=EVOLVED_DATASET,
    params:
        by=["epoch", "island", "step"],
        code=code_of("join"),
    message:
        "Joining the history of {wildcards.dataset}"
