"""Resources of jobs on a cluster, from measurements: docs/running.md. No rules here.

On a single machine only the threads matter. With `retries` of a profile, the second attempt of a
job requests twice its resources, the third three times, and so on.
"""

# All threads: --cores sets the limit on a machine, max-threads of a profile on a cluster.
MAX_THREADS = 64

# What a scheduler counts beside the job itself: the two processes of Snakemake that start it.
SNAKEMAKE_MB = 700


def needs(mb, minutes, mb_per_thread=0):
    """Memory and run time of the jobs of a rule, by resource; without Snakemake's own memory."""
    mb += SNAKEMAKE_MB
    return {
        "mem_mb": lambda wildcards, threads, attempt: attempt * (mb + mb_per_thread * threads),
        "runtime": lambda wildcards, attempt: attempt * minutes,
    }
