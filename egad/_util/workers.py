"""Work spread over processes, in an order and with results that do not depend on how many."""

import multiprocessing
import os
import pickle
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from egad._util.parameters import check_count
from egad._util.progress import report_compilation
from egad.errors import LESS_MEMORY, UserError

# New processes, not copies of this one, which have its locks without the threads that hold them.
ANEW = multiprocessing.get_context("spawn")
UNGUARDED = (
    "could not start: with several jobs, a script needs "
    '`if __name__ == "__main__":` around its calls'
)
NOT_IMPORTABLE = "with several jobs, functions must be in a module that can be imported"
Work = Callable[[Any], Any]
Mapper = Callable[[Work, Iterable[Any]], Iterable[Any]]


@contextmanager
def workers(count: int, chunk: int = 2) -> Iterator[Mapper]:
    """A `map` that keeps order and runs in several processes.

    They import the module of the work, so a program that calls this from its top level needs
    `if __name__ == "__main__":` there.

    Args:
        count: Processes; with 1, the work is done in this one.
        chunk: Items that a process takes at once: 1 for long work.

    Raises:
        UserError: The count is not allowed, the work cannot be imported by other processes, or a
            process has ended.
    """
    if check_count("jobs", count) == 1:
        with one_thread():
            yield map
        return
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise SystemExit(1)  # a worker that runs the program again; the first process reports it
    started = ANEW.Event()

    def mapper(work: Work, items: Iterable[Any]) -> Iterable[Any]:
        _check_importable(work)
        return pool.map(partial(_told, work), items, chunksize=chunk)

    try:
        with ProcessPoolExecutor(count, ANEW, _start_worker, (started,)) as pool:
            yield mapper
    except BrokenProcessPool as error:
        reason = f"ended unexpectedly, probably out of memory; {LESS_MEMORY}"
        raise UserError(f"a worker process {reason if started.is_set() else UNGUARDED}") from error


def _check_importable(work: Work) -> None:
    """Make sure that other processes can import a function.

    Raises:
        UserError: They cannot.
    """
    try:
        names = pickle.dumps(work)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise UserError(f"{NOT_IMPORTABLE} ({error})") from error
    if b"__main__" in names and not Path(_main_file()).is_file():
        raise UserError(f"{NOT_IMPORTABLE}; one of a notebook or a prompt cannot")


def _main_file() -> str:
    """The file of the program; empty or no file in a notebook or at a prompt."""
    return getattr(sys.modules["__main__"], "__file__", None) or ""


def _told(work: Work, item: Any) -> Any:  # noqa: ANN401 (whatever the work takes and gives)
    """Do the work on an item in a process that says when it compiles kernels."""
    report_compilation()
    return work(item)


def _start_worker(started: Event) -> None:
    """Prepare a process of a pool; it ends when the one that it works for is killed."""
    started.set()
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
