"""Report: an overview of all results, in one HTML file that works offline.

Inputs: the tables and meshes of all datasets, and the results of the targets.
Outputs: results/report.html.
"""


rule report:
    """Write the report."""
    input:
        published(),
    output:
        # an older one stays until this one is written
        ensure(update("results/report.html"), non_empty=True),
    log:
        "logs/report.log",
    benchmark:
        "benchmarks/report.tsv"
    conda:
        ENVIRONMENT
    threads: SIDE_BY_SIDE
    resources:
        **needs(mb=1000, mb_per_thread=300, minutes=30),
    params:
        settings=SETTINGS.model_dump_json(),
        meanings=MEANINGS,
        results=subpath(output[0], parent=True),
        code=code_of("report"),
    message:
        "Writing the report"
    shell:
        "egad report --settings {params.settings:q} --results {params.results:q} --out {output:q}"
        " --jobs {threads} {input:q} > {log:q} 2>&1"
