"""Work in a process of its own, which can die or be stopped without harm to this one."""

import json
import logging
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from typing import Any, Self

from egad._util.workers import Work, one_thread
from egad.errors import LESS_MEMORY, RejectedError, UserError

log = logging.getLogger(__name__)

CHANCES = 2
ENDING_TIME = 5.0  # seconds
Opened = Callable[[], AbstractContextManager[Work]]


class WorkerDiedError(Exception):
    """The process of a worker ended by itself; the text says how."""


class WorkerTimeoutError(Exception):
    """A worker took too long and was stopped."""


# All that a new process needs to import what this one can. It does not import the program, as
# `multiprocessing` does, so programs need no `if __name__ == "__main__":`.
CHILD = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from egad._util.child_process import serve; serve(int(sys.argv[2]))"
)


class Worker:
    """Work in a process of its own, which can die or be stopped without harm to this one.

    After that, the next item starts a new process.
    """

    def __init__(
        self,
        opened: Opened,
        limit: float | None = None,
        start_limit: float | None = None,
        name: str = "a worker process",
        environment: Mapping[str, str] | None = None,
        quiet: bool = False,
    ) -> None:
        """Prepare; the process starts with the `with` block or with the first item.

        Args:
            opened: Makes what does the work, in that process: a context manager that lasts as
                long. Its name must be importable there.
            limit: Seconds for one item. None for as long as it takes.
            start_limit: Seconds to start. None for as long as it takes.
            name: What to call it in messages.
            environment: Variables that it has besides those of this process.
            quiet: Whether what it prints is dropped.
        """
        self._environment, self._quiet = environment or {}, quiet
        self._opened, self._limit, self._start_limit = opened, limit, start_limit
        self._name = name
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def running(self) -> bool:
        """Whether there is a process; else the next item starts one."""
        return self._process is not None

    def __call__(self, item: Any) -> Any:  # noqa: ANN401 (whatever the work takes and gives)
        """Do the work on one item.

        Raises:
            WorkerTimeoutError: It took too long.
            WorkerDiedError: The process ended.
            UserError: The process was killed, or cannot be started.
            Exception: What the work raises; one with the same text if it cannot be pickled.
        """
        if not self.running:
            self.start()
        try:
            self._pipe.send(item)
            if not self._pipe.poll(self._limit):
                self.stop(patience=0)
                raise WorkerTimeoutError(f"{self._name} did not answer within {self._limit:g} s")
            result, error = self._pipe.recv()
        except (EOFError, OSError) as gone:
            raise WorkerDiedError(self._ending()) from gone
        if error is not None:
            raise error
        return result

    def start(self) -> None:
        """Start the process.

        Raises:
            UserError: It was killed, ended, or took too long.
            Exception: What `opened` raises.
        """
        opened = ForkingPickler.dumps(self._opened)
        self._pipe, theirs = multiprocessing.Pipe()
        where = json.dumps([path for path in sys.path if isinstance(path, str)])
        with theirs:
            number = theirs.fileno()
            self._process = subprocess.Popen(  # noqa: S603
                [sys.executable, "-c", CHILD, where, str(number)],
                env={**os.environ, **self._environment},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL if self._quiet else None,
                stderr=subprocess.DEVNULL if self._quiet else None,
                pass_fds=[number],
            )
        try:
            self._pipe.send_bytes(opened)
            if not self._pipe.poll(self._start_limit):
                self.stop(patience=0)
                raise UserError(f"{self._name} was not ready within {self._start_limit:g} s")
            _, error = self._pipe.recv()
        except (EOFError, OSError) as gone:
            raise UserError(f"{self._ending()} while it started") from gone
        if error is not None:
            self.stop()
            raise error

    def _ending(self) -> str:
        """How a process ended that does not answer any more, in words.

        Raises:
            UserError: It was killed, as Linux does when memory runs out.
        """
        status = self.stop()
        if status == -signal.SIGKILL:
            raise UserError(f"{self._name} was killed, probably out of memory; {LESS_MEMORY}")
        return f"{self._name} {'hung up' if status is None else f'ended with status {status}'}"

    def stop(self, patience: float = ENDING_TIME) -> int | None:
        """End the process; returns its status if it ends by itself within `patience` seconds."""
        process, self._process = self._process, None
        if process is None:
            return None
        self._pipe.close()  # it ends by itself when nobody can ask any more
        try:
            return process.wait(patience)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            return None


class Survivor:
    """Work in one thread of a process of its own, started anew when it dies or takes too long."""

    def __init__(self, opened: Opened, limit: float | None = None) -> None:
        """Prepare; the process starts with the `with` block.

        Args:
            opened: As of `Worker`.
            limit: Seconds for one item; a process that takes longer counts as one that died.
        """
        self._worker = Worker(partial(_in_one_thread, opened), limit)

    def __enter__(self) -> Self:
        self._worker.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._worker.__exit__(*error)

    def __call__(self, item: Any) -> Any:  # noqa: ANN401 (whatever the work takes and gives)
        """Do the work on one item.

        Returns:
            Its result; None if the process died of it twice.

        Raises:
            UserError: The process was killed.
            Exception: What the work raises; one with the same text if it cannot be pickled.
        """
        for _ in range(CHANCES):
            try:
                return self._worker(item)
            except (WorkerDiedError, WorkerTimeoutError) as error:
                log.warning("%s", error)
        return None


@contextmanager
def _in_one_thread(opened: Opened) -> Iterator[Work]:
    with one_thread(), opened() as work:
        yield work


def serve(number: int) -> None:
    """Work for the process at the other end of a pipe until it closes it.

    The first message tells what makes the work, and the first answer says that it is made.

    Args:
        number: File descriptor of this end.
    """
    with Connection(number) as pipe, ExitStack() as stack:
        try:
            work = stack.enter_context(pipe.recv()())
        except EOFError:
            return
        except Exception as error:
            pipe.send((None, _portable(error)))
            return
        pipe.send((None, None))
        while True:
            try:
                item = pipe.recv()
            except EOFError:
                return
            try:
                pipe.send(_answer(work, item))
            except Exception as reason:  # the result cannot be pickled
                pipe.send((None, _portable(reason)))


def _answer(work: Work, item: Any) -> tuple[Any, Exception | None]:  # noqa: ANN401 (as above)
    """What comes of an item, or what it raises."""
    try:
        return work(item), None
    except Exception as error:
        return None, _portable(error)


def _portable(error: Exception) -> Exception:
    """An error as it is if it can be sent; else one with its text."""
    try:
        pickle.loads(pickle.dumps(error))  # noqa: S301 (our own)
    except Exception:
        for kind in (UserError, RejectedError):
            if isinstance(error, kind):
                return kind(str(error))
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
