"""The limit on memory that this process runs under, as a queue of a cluster sets it."""

import errno
import os
import resource

from egad.errors import UserError

NEEDED = 1_400_000_000  # bytes of addresses that loading and compiling everything takes


def memory_limit() -> int | None:
    """Bytes of addresses that this process may have; None for any number."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if limit == resource.RLIM_INFINITY else limit


def check_memory() -> None:
    """Raise `UserError` if libraries would crash in the memory allowed, even with one thread."""
    if limit := memory_limit():
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # each takes up to 80 MB of addresses
        if limit < NEEDED:
            raise UserError(out_of_memory(f"{NEEDED >> 20:,} MB are needed at least"))


def out_of_memory(details: object = "") -> str:
    """A message with the limit if there is one."""
    what = f"out of memory ({details})" if details else "out of memory"
    if not (limit := memory_limit()):
        return what
    return (
        f"{what}; the limit is {limit >> 20:,} MB (ulimit -v {limit >> 10}; on a cluster, the "
        "memory that the job requests)"
    )


def is_out_of_memory(error: Exception) -> bool:
    """Whether an error says that memory ran out, and nothing about what was being done."""
    match error:
        case MemoryError() | OSError(errno=errno.ENOMEM):
            return True
        case RuntimeError():
            return "can't start new thread" in str(error)
    return False
