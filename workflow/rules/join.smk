"""Join: the tables of all shards become one. Other rules are copies of this one (`use rule`).

They name input, output, log, benchmark and message, and the columns to sort by.
"""


rule join:
    """Join the tables of all shards, sorted so that their number leaves no trace."""
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
    shell:
        "egad join {params.by:q} --out {output:q} {input:q} > {log:q} 2>&1"
