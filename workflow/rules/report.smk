"""Report: an overview of all results, in one HTML file that works offline.

Inputs: the tables and meshes of all datasets, and the results of the targets.
Outputs: results/report.html.
"""


rule report:
    """Write the report."""
    input:
        published(),
    output:
        # an older report stays until this one is written
        out=report(
            ensure(update("results/report.html"), non_empty=True),
            caption="../report/overview.rst",
            category="Overview",
        ),
    log:
        "logs/report.log",
    benchmark:
        "benchmarks/report.tsv"
    conda:
        ENVIRONMENT
    threads: MAX_THREADS
    resources:
        **needs(mb=1000, mb_per_thread=300, minutes=30),
    params:
        settings=SETTINGS.model_dump(mode="json"),
        meanings=MEANINGS,
        results=subpath(output.out, parent=True),
        code=code_of("report"),
    message:
        "Writing the report"
    script:
        "../scripts/report.py"
