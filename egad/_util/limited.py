"""Functions that may take any amount of memory or time, in a process that may not.

Parsers of other programs' files run here. One process serves all calls of the program; it starts
with the first of them, and again after a call that passed a limit.
"""

import atexit
import multiprocessing
import os
import resource
import subprocess
import sys
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from egad._util import input_limits
from egad._util.workers import ENDING_TIME, check_not_killed
from egad.errors import RejectedError, TableError, UserError

T = TypeVar("T")

# Threads and memory pools reserve far more addresses than they use.
_ENVIRONMENT = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MALLOC_ARENA_MAX": "1",
    "ARROW_DEFAULT_MEMORY_POOL": "system",
}
_CHILD = f"from {__name__} import serve; serve()"


class LimitError(Exception):
    """A function took more memory or time than it may, or ended its process."""


class FailedError(Exception):
    """A function raised an error that it does not document; the text names its type."""


class LimitedProcess:
    """Calls functions in another process, with a limit on its memory and on the time of a call."""

    def __init__(
        self,
        memory: int = input_limits.MAX_MEMORY,
        seconds: float = input_limits.MAX_SECONDS,
    ) -> None:
        """Prepare; the process starts with the first call.

        Args:
            memory: Bytes of its address space.
            seconds: Time that a call may take.
        """
        self._memory, self._seconds = memory, seconds
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._owner = 0

    def __call__(self, function: Callable[..., T], *arguments: object) -> T:
        """Call a function of a module.

        Args:
            function: Its name must be importable.
            arguments: For it. These and the result can be pickled.

        Raises:
            LimitError: It took too much memory or time, or its process ended.
            FailedError: It raised an error other than `RejectedError`, `TableError` and
                `UserError`, which are passed on.
            UserError: The system killed the process.
        """
        with self._lock:
            if self._process is None or self._owner != os.getpid():
                self._start()
            try:
                result, error = self._answer(function, arguments)
            except BaseException:
                self.close()
                raise
        if error is not None:
            raise error
        return result

    def close(self) -> None:
        """End the process, whatever it does."""
        process, self._process = self._process, None
        if process is None or self._owner != os.getpid():
            return  # a copy of the program has no process of its own yet
        self._pipe.close()
        process.kill()
        process.wait()

    def _start(self) -> None:
        self._pipe, theirs = multiprocessing.Pipe()
        with theirs:
            self._process = subprocess.Popen(  # noqa: S603
                [sys.executable, "-P", "-c", _CHILD, str(theirs.fileno()), str(self._memory)],
                pass_fds=[theirs.fileno()],
                env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **_ENVIRONMENT},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        self._owner = os.getpid()

    def _answer(
        self, function: Callable[..., T], arguments: tuple[Any, ...]
    ) -> tuple[T, Exception | None]:
        """The result of a call, and the error that it raised, if any."""
        try:
            self._pipe.send((function, arguments))
            if not self._pipe.poll(self._seconds):
                raise LimitError(f"it takes more than {self._seconds:g} s to read")
            answer: tuple[T, Exception | None] = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise LimitError(f"its reader {self._end()}") from error
        if isinstance(answer[1], MemoryError):
            raise LimitError(f"it takes more than {self._memory >> 20:,} MiB of memory to read")
        return answer

    def _end(self) -> str:
        """How a process ended that does not answer any more, in words.

        Raises:
            UserError: The system killed it.
        """
        try:
            status = self._process.wait(ENDING_TIME) if self._process else None
        except subprocess.TimeoutExpired:
            return "hung up"
        check_not_killed(status, "the process that reads files")
        return f"ended with status {status}"


limited = LimitedProcess()
atexit.register(limited.close)


def serve() -> None:
    """Call what comes through a pipe until its other end closes: the work of the process.

    Its arguments are the descriptor of the pipe, and the limit of memory.
    """
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[2]),) * 2)
    pipe = Connection(int(sys.argv[1]))
    while True:
        try:
            function, arguments = pipe.recv()
        except (EOFError, OSError):
            return
        pipe.send(_outcome(function, arguments))


def _outcome(function: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[Any, Any]:
    try:
        return function(*arguments), None
    except MemoryError:
        return None, MemoryError()
    except (RejectedError, TableError, UserError) as error:
        return None, type(error)(str(error))
    except Exception as error:
        return None, FailedError(f"{type(error).__name__}: {error}")
