"""Work spread over processes; its order and results do not depend on their number."""

import signal
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache, partial
from queue import SimpleQueue
from typing import Any, NamedTuple

from egad._util.child_process import (
    Work,
    Worker,
    WorkerDiedError,
    WorkerKilledError,
    from_bytes,
    one_thread,
    to_bytes,
)
from egad._util.parameters import check_count
from egad.errors import UserError

Mapper = Callable[[Work, Iterable[Any]], Iterable[Any]]
SHOWN = 100  # characters of an item


@contextmanager
def workers(count: int) -> Iterator[Mapper]:
    """A `map` that keeps order, in several processes; `UserError` shows the item if one ended."""
    if check_count("jobs", count) == 1:
        with one_thread():
            yield map
        return
    processes = [Worker(_worker_context) for _ in range(count)]
    threads, idle = ThreadPoolExecutor(count), SimpleQueue[Worker]()
    for process in processes:
        idle.put(process)

    def mapper(work: Work, items: Iterable[Any]) -> Iterable[Any]:
        ask = partial(_ask_idle_worker, idle, to_bytes(work))
        return map(_with_warnings_given, threads.map(ask, items))

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
            process.close_pipe()
        for process in processes:
            process.stop()


class _Answer(NamedTuple):
    """What a process returns for an item: the result, and the warnings with their file and line."""

    result: Any
    warnings: list[tuple[str, type[Warning], str, int]]


def _ask_idle_worker(idle: SimpleQueue[Worker], work: bytes, item: Any) -> _Answer:  # noqa: ANN401
    """Have an idle process do pickled work on an item."""
    process = idle.get()
    try:
        answer: _Answer = process((work, item))
    except (WorkerDiedError, WorkerKilledError) as error:
        text = " ".join(repr(item).split())
        shown = text if len(text) <= SHOWN else f"{text[: SHOWN - 3]}..."
        raise UserError(f"{error} (its item: {shown})") from error
    finally:
        idle.put(process)
    return answer


def _with_warnings_given(answer: _Answer) -> Any:  # noqa: ANN401 (whatever the work gives)
    """The result of another process, whose warnings are issued here."""
    for warning in answer.warnings:
        warnings.warn_explicit(*warning)
    return answer.result


@contextmanager
def _worker_context() -> Iterator[Work]:
    """The work of a process of a pool. Interrupts are left to the process that it works for."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with one_thread():
        yield _run_recording_warnings


def _run_recording_warnings(task: tuple[bytes, Any]) -> _Answer:
    """Do pickled work on an item, and keep the warnings."""
    pickled, item = task
    work = _load_work(pickled)
    with warnings.catch_warnings(record=True) as found:
        result = work(item)
    return _Answer(result, [(str(w.message), w.category, w.filename, w.lineno) for w in found])


@lru_cache(4)
def _load_work(pickled: bytes) -> Work:
    """Unpickle work once for many items, with all that it caches; evolution alternates a few."""
    work: Work = from_bytes(pickled)
    return work
