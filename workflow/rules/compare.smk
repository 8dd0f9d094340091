"""Compare: a comparison of all datasets of the configuration.

Inputs: results/D/objects.parquet of every dataset.
Outputs: results/comparison.parquet, results/comparison.svg; the table is also printed.
"""


localrules:
    compare,


rule compare:
    """Compare objects, coverage and diversity of the datasets, with maps."""
    input:
        of_datasets(SETTINGS.datasets, ["objects.parquet"]),
    output:
        table=ensure("results/comparison.parquet", non_empty=True),
        figure=ensure("results/comparison.svg", non_empty=True),
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
        settings=settings_of("compare"),
        named=lambda wildcards, input: [f"{Path(file).parent.name}={file}" for file in input],
        code=code_of("compare"),
    message:
        "Comparing the datasets"
    shell:
        "egad compare --settings {params.settings:q} --out {output.table:q}"
        " --figure {output.figure:q} {params.named:q} > {log:q} 2>&1"
