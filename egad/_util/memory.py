"""The limit on memory that this process runs under, as a queue of a cluster sets it."""

import errno
import os
import resource

from egad.errors import UserError

# Names in the shell, and bytes that loading and compiling everything takes.
LIMITS = {resource.RLIMIT_AS: ("v", 1_400_000_000), resource.RLIMIT_DATA: ("d", 700_000_000)}


def memory_limit() -> int | None:
    """Bytes of addresses or of data that this process may have, the lower of both; None for any."""
    return min((limit for limit, *_ in _limits()), default=None)


def check_memory() -> None:
    """Check that the limit lets egad be loaded: in less memory, libraries crash.

    Raises:
        UserError: It does not.
    """
    for limit, option, needed in _limits():
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # each takes up to 80 MB of addresses
        if limit < needed:
            raise UserError(
                f"out of memory: {needed >> 20:,} MB are needed at least; {_named(limit, option)}"
            )


def out_of_memory(details: object = "") -> str:
    """A message with the limit if there is one."""
    what = f"out of memory ({details})" if details else "out of memory"
    limits = sorted(_limits())
    return f"{what}; {_named(*limits[0][:2])}" if limits else what


def is_out_of_memory(error: Exception) -> bool:
    """Whether an error says that memory ran out, and nothing about what was being done."""
    match error:
        case MemoryError() | OSError(errno=errno.ENOMEM):
            return True
        case RuntimeError():
            return "can't start new thread" in str(error)
    return False


def _limits() -> list[tuple[int, str, int]]:
    """The limits that hold, each with its name in the shell and what egad needs."""
    found = [(resource.getrlimit(kind)[0], *about) for kind, about in LIMITS.items()]
    return [limit for limit in found if limit[0] != resource.RLIM_INFINITY]


def _named(limit: int, option: str) -> str:
    return (
        f"the limit is {limit >> 20:,} MB (ulimit -{option} {limit >> 10}; on a cluster, the "
        "memory that the job requests)"
    )
