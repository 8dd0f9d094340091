"""Work spread over processes, in an order and with results that do not depend on how many."""

import logging
import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial
from multiprocessing.connection import Connection
from typing import Any, Self

from threadpoolctl import threadpool_limits

from egad._util.progress import report_compilation
from egad.errors import LESS_MEMORY, RejectedError, UserError

log = logging.getLogger(__name__)

CHANCES = 2
ENDING_TIME = 5.0  # seconds
# New processes, not copies of this one, which have its locks without the threads that hold them.
ANEW = multiprocessing.get_context("spawn")
KILLED = "was killed, probably for want of memory"
Work = Callable[[Any], Any]
Mapper = Callable[[Work, Iterable[Any]], Iterable[Any]]
Opened = Callable[[], AbstractContextManager[Work]]


@contextmanager
def workers(count: int) -> Iterator[Mapper]:
    """A `map` that keeps order and runs in `count` processes (in this one if 1).

    They import the module of the work, so a program that calls this from its top level needs
    `if __name__ == "__main__":` there.
    """
    if count == 1:
        with _one_thread():
            yield map
        return
    try:
        with ProcessPoolExecutor(count, ANEW, _start_worker) as pool:
            yield lambda work, items: pool.map(partial(_told, work), items, chunksize=2)
    except BrokenProcessPool as error:
        raise UserError(
            f"a worker process ended all at once, probably for want of memory; {LESS_MEMORY}"
        ) from error


def _told(work: Work, item: Any) -> Any:  # noqa: ANN401 (whatever the work takes and gives)
    """Do the work on an item in a process that says when it compiles kernels."""
    report_compilation()
    return work(item)


def check_not_killed(status: int | None, who: str) -> None:
    """Tell a process that was killed from one that failed: its work is not to blame.

    Args:
        status: How it ended.
        who: What to call it.

    Raises:
        UserError: It was killed, as Linux does when memory runs out.
    """
    if status == -signal.SIGKILL:
        raise UserError(f"{who} {KILLED}; {LESS_MEMORY}")


def _start_worker() -> None:
    """Prepare a process of a pool; it ends when the one that it works for is killed."""
    _one_thread()
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    if parent := multiprocessing.parent_process():
        parent.join()
        os._exit(1)


def _one_thread() -> threadpool_limits:
    """Algebra in one thread: else each process has one for every core, and they wait."""
    import scipy.linalg  # noqa: F401, PLC0415 (only libraries that are loaded can be limited)

    return threadpool_limits(1)


class Survivor:
    """Work in a process of its own that is started anew when it dies, or takes too long."""

    def __init__(self, opened: Opened, limit: float | None = None) -> None:
        """Prepare; the process starts with the `with` block.

        Args:
            opened: Makes what does the work, in that process: a context manager that lasts as
                long. Its name must be importable there.
            limit: Seconds for one item; a process that takes longer is ended, and counts as one
                that died. None for as long as it takes.
        """
        self._opened, self._limit = opened, limit

    def __enter__(self) -> Self:
        self._start()
        return self

    def __exit__(self, *_: object) -> None:
        self._pipe.close()  # it ends by itself when nobody can ask any more
        self._process.join(ENDING_TIME)
        self._process.kill()
        self._process.join()

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
                self._pipe.send(item)
                if not self._pipe.poll(self._limit):
                    log.warning("a process was ended after %s seconds", self._limit)
                    self._process.terminate()
                result, error = self._pipe.recv()
            except (EOFError, OSError):
                self._process.join()
                check_not_killed(self._process.exitcode, "a worker process")
                log.warning("a process ended with status %s", self._process.exitcode)
                self._start()
                continue
            if error is not None:
                raise error
            return result
        return None

    def _start(self) -> None:
        self._pipe, theirs = ANEW.Pipe()
        self._process = ANEW.Process(target=_serve, args=(theirs, self._opened))
        self._process.start()
        theirs.close()
        try:
            _, error = self._pipe.recv()
        except EOFError:
            self._process.join()
            check_not_killed(self._process.exitcode, "a worker process")
            raise UserError(
                f"a worker process ended with status {self._process.exitcode} while it started"
            ) from None
        if error is not None:
            self._process.join()
            raise error


def _serve(pipe: Connection, opened: Opened) -> None:
    """Do the work until the other end of the pipe closes; the first answer says that it can."""
    with _one_thread(), ExitStack() as stack:
        try:
            work = stack.enter_context(opened())
        except Exception as error:
            pipe.send((None, _portable(error)))
            return
        report_compilation()
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
