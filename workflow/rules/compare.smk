"""Compare: a comparison of all datasets of the configuration.

Inputs: results/D/objects.parquet of every dataset.
Outputs: results/comparison.parquet, results/comparison.svg; the table is also printed.
"""

from egad.measures import MeasureParameters


localrules:
    compare,


rule compare:
    """Compare objects, coverage and diversity of the datasets, with maps."""
    input:
        objects=of_datasets(SETTINGS.datasets, ["objects.parquet"]),
    output:
        out=ensure("results/comparison.parquet", non_empty=True),
        figure=report(
            ensure("results/comparison.svg", non_empty=True),
            caption="../report/comparison.rst",
            category="Datasets",
        ),
    log:
        "logs/compare.log",
    benchmark:
        "benchmarks/compare.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, minutes=10),
    params:
        settings=settings_of(MeasureParameters),
        datasets=list(SETTINGS.datasets),
        code=code_of("compare"),
    message:
        "Comparing the datasets"
    script:
        "../scripts/compare.py"
