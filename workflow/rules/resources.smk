"""What jobs ask of a cluster; measured, see docs/cluster.md. No rules here.

A machine of one's own heeds the threads alone. Where a job is tried again (`retries` of a profile),
it asks for as much once more each time.
"""

# As many as there are: --cores sets the limit on a machine, max-threads of a profile on a cluster.
SIDE_BY_SIDE = 64


def needs(mb, minutes, mb_per_thread=0):
    """Memory and run time of the jobs of a rule, by the resource that the executors know."""
    return {
        "mem_mb": lambda wildcards, threads, attempt: attempt * (mb + mb_per_thread * threads),
        "runtime": lambda wildcards, attempt: attempt * minutes,
    }
