"""Work spread over processes, in an order and with results that do not depend on how many."""

import signal
import textwrap
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from queue import SimpleQueue
from typing import Any, NamedTuple

from egad._util.child_process import (
    Work,
    Worker,
    WorkerDiedError,
    WorkerKilledError,
    one_thread,
)
from egad._util.parameters import check_count
from egad.errors import UserError

Mapper = Callable[[Work, Iterable[Any]], Iterable[Any]]
SHOWN = 100  # characters of an item


@contextmanager
def workers(count: int) -> Iterator[Mapper]:
    """A `map` that keeps order and runs in several processes.

    Args:
        count: Processes; with 1, the work is done in this one.

    Raises:
        UserError: The count is not allowed, the work or an item cannot be sent to other processes,
            or a process has ended; the message shows its item.
    """
    if check_count("jobs", count) == 1:
        with one_thread():
            yield map
        return
    processes = [Worker(_ready) for _ in range(count)]
    threads, idle = ThreadPoolExecutor(count), SimpleQueue[Worker]()
    for process in processes:
        idle.put(process)

    def mapper(work: Work, items: Iterable[Any]) -> Iterable[Any]:
        return map(_warned, threads.map(partial(_ask, idle, work), items))

    try:
        yield mapper
    except BaseException:
        threads.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.kill()
        raise
    finally:
        threads.shutdown()
        for process in processes:
            process.stop(patience=0)


class _Told(NamedTuple):
    """What a process has to say: its result, and the warnings with their file and line."""

    result: Any
    warnings: list[tuple[str, type[Warning], str, int]]


def _ask(idle: SimpleQueue[Worker], work: Work, item: Any) -> _Told:  # noqa: ANN401 (of the work)
    """Have an idle process do work on an item."""
    process = idle.get()
    try:
        told: _Told = process((work, item))
    except (WorkerDiedError, WorkerKilledError) as error:
        shown = textwrap.shorten(repr(item), SHOWN, placeholder="...")
        raise UserError(f"{error} (its item: {shown})") from error
    finally:
        idle.put(process)
    return told


def _warned(told: _Told) -> Any:  # noqa: ANN401 (whatever the work gives)
    """The result of another process, whose warnings are given here."""
    for warning in told.warnings:
        warnings.warn_explicit(*warning)
    return told.result


@contextmanager
def _ready() -> Iterator[Work]:
    """What a process of a pool does. Interrupts are for the one that it works for."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with one_thread():
        yield _told


def _told(task: tuple[Work, Any]) -> _Told:
    """Do work on an item, and keep the warnings."""
    work, item = task
    with warnings.catch_warnings(record=True) as found:
        result = work(item)
    return _Told(result, [(str(w.message), w.category, w.filename, w.lineno) for w in found])
