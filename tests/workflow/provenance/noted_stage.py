"""A stage that notes what its files were made from."""

from contextlib import contextmanager

from egad.io.sums import write_sums
from egad_workflow.provenance import recorded


@contextmanager
def stage(name, settings, reads, writes=(), **arguments):
    """What is written in the block was made by a stage, from files and folders."""
    code = "0123456789abcdef"
    with recorded(name, code=code, settings=settings, arguments=arguments, inputs=reads):
        yield
        for path in writes:
            write_sums(path)
