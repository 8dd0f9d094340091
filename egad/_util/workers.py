"""Work spread over processes, in an order and with results that do not depend on how many."""

import multiprocessing
import os
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from typing import Any

from threadpoolctl import threadpool_limits

from egad._util.progress import report_compilation
from egad.errors import LESS_MEMORY, UserError

# New processes, not copies of this one, which have its locks without the threads that hold them.
ANEW = multiprocessing.get_context("spawn")
Work = Callable[[Any], Any]
Mapper = Callable[[Work, Iterable[Any]], Iterable[Any]]


@contextmanager
def workers(count: int) -> Iterator[Mapper]:
    """A `map` that keeps order and runs in `count` processes (in this one if 1).

    They import the module of the work, so a program that calls this from its top level needs
    `if __name__ == "__main__":` there.
    """
    if count == 1:
        with one_thread():
            yield map
        return
    try:
        with ProcessPoolExecutor(count, ANEW, _start_worker) as pool:
            yield lambda work, items: pool.map(partial(_told, work), items, chunksize=2)
    except BrokenProcessPool as error:
        raise UserError(
            f"a worker process ended unexpectedly, probably out of memory; {LESS_MEMORY}"
        ) from error


def _told(work: Work, item: Any) -> Any:  # noqa: ANN401 (whatever the work takes and gives)
    """Do the work on an item in a process that says when it compiles kernels."""
    report_compilation()
    return work(item)


def _start_worker() -> None:
    """Prepare a process of a pool; it ends when the one that it works for is killed."""
    one_thread()
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    if parent := multiprocessing.parent_process():
        parent.join()
        os._exit(1)


def one_thread() -> threadpool_limits:
    """Algebra in one thread: else each process has one for every core, and they wait."""
    import scipy.linalg  # noqa: F401, PLC0415 (only libraries that are loaded can be limited)

    return threadpool_limits(1)
