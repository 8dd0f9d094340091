"""Functions of scripts, run as jobs of Snakemake but in the process of the tests."""

import logging
import sys
from unittest.mock import patch

from snakemake.iocontainers import (
    InputFiles,
    Log,
    OutputFiles,
    Params,
    ResourceList,
    Snakemake,
    Wildcards,
)

from egad_workflow.job import run_job


def job_of(rule, *, reads=(), writes=(), params=(), wildcards=(), threads=1):
    """What a script knows as `snakemake`, without a log: input, output and so on by name."""
    return Snakemake(
        _files(InputFiles(), dict(reads)),
        _files(OutputFiles(), dict(writes)),
        Params(fromdict=dict(params)),
        Wildcards(fromdict=dict(wildcards)),
        threads,
        ResourceList(),
        Log(),
        {},
        rule,
        None,
    )


def run_as_job(function, rule, **named):
    """Run the function of a script; what is named is that of `job_of`."""
    changed = [logging.getLogger(name) for name in ("egad", function.__module__)]
    levels = [logger.level for logger in changed]
    try:
        with patch.dict(vars(sys.modules["__main__"]), snakemake=job_of(rule, **named)):
            run_job(function)
    finally:
        for logger, level in zip(changed, levels, strict=True):
            logger.setLevel(level)


def _files(found, named):
    """The same as Snakemake has them: a name stands for a file or for a list."""
    for name, value in named.items():
        start = len(found)
        if isinstance(value, list):
            found.extend(map(str, value))
            found._set_name(name, start, len(found))
        else:
            found.append(str(value))
            found._add_name(name)
    return found
