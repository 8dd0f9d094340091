"""Work spread over processes, in an order and with results that do not depend on how many."""

import multiprocessing
import os
import pickle
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any, NamedTuple

from threadpoolctl import threadpool_limits

from egad._util.parameters import check_count
from egad.errors import LESS_MEMORY, UserError

# New processes, not copies of this one, which have its locks without the threads that hold them.
ANEW = multiprocessing.get_context("spawn")
UNGUARDED = (
    "could not start: with several jobs, a script needs "
    '`if __name__ == "__main__":` around its calls'
)
NO_FILE = "could not start: several jobs need a script that is a file; save the program, or use 1"
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
        pickled = _pickled(work)
        if b"__main__" in pickled and not Path(_main_file()).is_file():
            raise UserError(f"{NOT_IMPORTABLE}; one of a notebook or a prompt cannot")
        told = pool.map(partial(_told, pickled), map(_pickled, items), chunksize=chunk)
        return map(_warned, told)

    try:
        with ProcessPoolExecutor(count, ANEW, _start_worker, (started,)) as pool:
            try:
                yield mapper
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)  # else it does all that is queued
                raise
    except BrokenProcessPool as error:
        raise UserError(f"a worker process {_ending(started.is_set())}") from error


def _ending(started: bool) -> str:
    """Why the processes of a pool have ended, as far as it can be told."""
    if started:
        return f"ended unexpectedly, probably out of memory; {LESS_MEMORY}"
    program = _main_file()
    return NO_FILE if program and not Path(program).is_file() else UNGUARDED


def _pickled(what: Any) -> bytes:  # noqa: ANN401 (whatever the work takes, or the work)
    """Something as other processes get it.

    They unpickle it with the work, not in the queue of the pool: there, an error would end them.

    Raises:
        UserError: It cannot be pickled.
    """
    try:
        return pickle.dumps(what)
    except (pickle.PicklingError, AttributeError, TypeError, ValueError) as error:
        raise UserError(f"{NOT_IMPORTABLE} ({error})") from error


def _main_file() -> str:
    """The file of the program; empty or no file in a notebook or at a prompt."""
    return getattr(sys.modules["__main__"], "__file__", None) or ""


class _Told(NamedTuple):
    """What a process has to say: its result, and the warnings with their file and line."""

    result: Any
    warnings: list[tuple[str, type[Warning], str, int]]


def _warned(told: _Told) -> Any:  # noqa: ANN401 (whatever the work gives)
    """The result of another process, whose warnings are given here."""
    for warning in told.warnings:
        warnings.warn_explicit(*warning)
    return told.result


def _told(work: bytes, item: bytes) -> _Told:
    """Do pickled work on an item, and keep the warnings.

    Raises:
        UserError: The work or the item is of a module that this process does not have.
        Exception: What the work raises.
    """
    try:
        call, what = pickle.loads(work), pickle.loads(item)  # noqa: S301 (our own)
    except (ImportError, AttributeError) as error:
        raise UserError(f"{NOT_IMPORTABLE} ({error})") from error
    with warnings.catch_warnings(record=True) as found:
        result = call(what)
    return _Told(result, [(str(w.message), w.category, w.filename, w.lineno) for w in found])


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
