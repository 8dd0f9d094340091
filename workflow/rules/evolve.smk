"""Evolve: epochs of islands, merged.

Inputs: only the settings.
Outputs: results/D/archive.parquet, the elites; history.parquet, the steps;
ancestry.parquet, the elites and all their ancestors; epochs/, the
intermediate archives.
Steps: every island evolves from the merged archive of the previous epoch; the islands are merged;
the archive of the last epoch, or the source archive of a dataset, is published. More epochs than
before extend a finished run.
"""


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
    threads: SIDE_BY_SIDE
    resources:
        **needs(mb=1200, mb_per_thread=600, minutes=60),
    params:
        settings=settings_of("evolve"),
        base=each("--base", "base"),
        measures=MEASURES,
        contents=contents_of(region_meshes),
        page="logs/{dataset}/map.html",
        islands=island_count,
        code=code_of("evolve"),
    message:
        "Evolving {wildcards.dataset}, epoch {wildcards.epoch}, island {wildcards.island}"
        " (live map: {params.page})"
    shell:
        "egad evolve --settings {params.settings:q} --epoch {wildcards.epoch}"
        " --island {wildcards.island} {params.base:q} --jobs {threads} --page {params.page:q}"
        " --islands {params.islands} --out {output.archive:q} --history {output.history:q}"
        " --lineage {output.lineage:q} > {log:q} 2>&1"


rule merge:
    """Merge the islands of an epoch into one archive."""
    input:
        expand(
            "results/{{dataset}}/epochs/epoch-{{epoch}}/island-{island}.parquet",
            island=ISLANDS,
        ),
    output:
        ensure("results/{dataset}/epochs/epoch-{epoch}/archive.parquet", non_empty=True),
    log:
        "logs/{dataset}/merge/epoch-{epoch}.log",
    benchmark:
        "benchmarks/{dataset}/merge/epoch-{epoch}.tsv"
    wildcard_constraints:
        dataset=EVOLVED_DATASET,
    conda:
        ENVIRONMENT
    threads: SIDE_BY_SIDE
    resources:
        **needs(mb=1000, mb_per_thread=100, minutes=10),
    params:
        settings=settings_of("merge"),
        code=code_of("merge"),
    message:
        "Merging the islands of epoch {wildcards.epoch}"
    shell:
        "egad merge --settings {params.settings:q} --out {output:q} --jobs {threads} {input:q}"
        " > {log:q} 2>&1"


rule archive:
    """Publish the archive that the objects are made from."""
    input:
        final_archive,
    output:
        ensure("results/{dataset}/archive.parquet", non_empty=True),
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
        code=code_of("merge"),
    message:
        "Publishing the archive"
    shell:
        "egad archive {input:q} --out {output:q} > {log:q} 2>&1"


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
        ensure("results/{dataset}/ancestry.parquet", non_empty=True),
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
    shell:
        "egad ancestry --archive {input.archive:q} --out {output:q} {input.lineages:q}"
        " > {log:q} 2>&1"


use rule join as history with:
    input:
        expand(
            "results/{{dataset}}/epochs/epoch-{epoch}/history-{island}.parquet",
            epoch=range(LAST_EPOCH + 1),
            island=ISLANDS,
        ),
    output:
        ensure("results/{dataset}/history.parquet", non_empty=True),
    log:
        "logs/{dataset}/history.log",
    benchmark:
        "benchmarks/{dataset}/history.tsv"
    wildcard_constraints:
        dataset=EVOLVED_DATASET,
    params:
        by=["--by", "epoch", "--by", "island", "--by", "step"],
        code=code_of("join"),
    message:
        "Joining the history of {wildcards.dataset}"
