"""Join: the tables of all shards as one. Other rules are copies of this one (`use rule`).

They set input, output, log, benchmark, message, and the columns to sort by.
"""


rule join:
    """Join the tables of all shards, sorted to be independent of their number."""
    log:
        "logs/join.log",
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, minutes=10),
    params:
        by=[],
        code=code_of("join"),
    script:
        "../scripts/join.py"
