"""Which scripts of the workflow are running."""

import re


def script_of(process):
    """The name of the script that a process runs, of which Snakemake has made a copy; else none."""
    words = process.cmdline()
    found = re.search(r"/\.snakemake/scripts/\w+\.(\w+)\.py$", words[1]) if words[1:] else None
    return found[1] if found else None
