"""Runs functions that may take any amount of memory or time, in a process with limits.

Parsers of other programs' files run here. One process serves all calls of the program; it starts
with the first call, and again after a call that exceeded a limit.
"""

import atexit
import os
import resource
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, TypeVar

from egad._util import input_limits
from egad._util.child_process import Work, Worker, WorkerDiedError, WorkerTimeoutError
from egad._util.memory import is_out_of_memory, memory_limit, out_of_memory
from egad.errors import RejectedError, TableError, UserError

T = TypeVar("T")
NAME = "the process that reads files"

# Threads and memory pools reserve far more addresses than they use.
ENVIRONMENT = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MALLOC_ARENA_MAX": "1",
    "ARROW_DEFAULT_MEMORY_POOL": "system",
    "PXR_WORK_THREAD_LIMIT": "1",
}


class LimitError(Exception):
    """A function took more memory or time than allowed, or ended its process."""


class FailedError(Exception):
    """A function raised an error that it does not document; the text names its type."""


class LimitedProcess:
    """Calls functions in another process, with a limit on its memory and on the time of a call."""

    def __init__(
        self, memory: int = input_limits.MAX_MEMORY, seconds: float = input_limits.MAX_SECONDS
    ) -> None:
        """Prepare a process; limits of its memory, bytes, and of the time of a call, seconds."""
        self._memory, self._seconds = memory, seconds
        self._lock = threading.Lock()
        self._worker, self._owner = self._new_worker(), os.getpid()

    def __call__(self, function: Callable[..., T], *arguments: object) -> T:
        """Call a function of a module; raises `LimitError`, `FailedError`, or an error of egad."""
        with self._lock:
            if self._owner != os.getpid():  # a fork of the program has no worker of its own yet
                self._worker, self._owner = self._new_worker(), os.getpid()
            if not self._worker.running:
                try:
                    self._worker.start()
                except Exception as error:  # whatever it is, the file is not to blame
                    why = out_of_memory() if is_out_of_memory(error) else error
                    raise UserError(f"{NAME} cannot be started: {why}") from error
            try:
                result: T = self._worker((function, arguments))
            except WorkerTimeoutError as error:
                raise LimitError(f"it takes more than {self._seconds:g} s to read") from error
            except (RejectedError, TableError, UserError):
                raise
            except Exception as error:
                if isinstance(error, WorkerDiedError) or is_out_of_memory(error):
                    self._worker.stop()
                    raise self._limit_error(error) from error
                raise FailedError(f"{type(error).__name__}: {error}") from error
        return result

    def close(self) -> None:
        """End the process, whatever it does."""
        if self._owner == os.getpid():
            self._worker.stop()

    def _new_worker(self) -> Worker:
        return Worker(
            partial(_with_limit, self._memory),
            self._seconds,
            name=NAME,
            environment=ENVIRONMENT,
            quiet=True,
        )

    def _limit_error(self, error: Exception) -> Exception:
        if isinstance(error, WorkerDiedError):
            return LimitError(error)
        if (memory_limit() or self._memory) < self._memory:
            return UserError(out_of_memory())
        return LimitError(f"it takes more than {self._memory >> 20:,} MiB of memory to read")


@contextmanager
def _with_limit(memory: int) -> Iterator[Work]:
    """Calls functions in this process, which may take at most `memory` bytes from now on."""
    memory = min(memory, memory_limit() or memory)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    yield _call


def _call(item: tuple[Callable[..., Any], tuple[Any, ...]]) -> Any:  # noqa: ANN401 (of any function)
    function, arguments = item
    return function(*arguments)


limited = LimitedProcess()
atexit.register(limited.close)
