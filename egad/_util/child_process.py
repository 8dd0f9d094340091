"""Work in a process of its own, which can die or be stopped without harm to this one."""

import fcntl
import functools
import importlib
import io
import json
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import traceback
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, ExitStack, suppress
from multiprocessing.connection import Connection
from operator import attrgetter
from types import ModuleType
from typing import Any, Self, TypeGuard

import cloudpickle
from threadpoolctl import threadpool_limits

from egad._util.input_limits import MAX_MEMORY
from egad._util.memory import memory_limit, out_of_memory
from egad.errors import LESS_MEMORY, EgadError, RejectedError, UserError

ENDING_TIME = 5.0  # seconds
NOT_SENT = (
    "this cannot be sent to another process, which more than one job requires; "
    "put it into a module of its own, or use 1 job"
)
CACHED = type(functools.cache(len))
Work = Callable[[Any], Any]
MakeWork = Callable[[], AbstractContextManager[Work]]


class WorkerDiedError(Exception):
    """The process of a worker ended by itself; the text says how."""


class WorkerKilledError(UserError):
    """The process of a worker was killed, as Linux does when memory runs out."""


class WorkerTimeoutError(Exception):
    """A worker took too long and was stopped."""


class _RemoteError(Exception):
    """An error in another process; the text is its traceback."""


# All that a new process needs to import what this one can. It does not import the program, as
# `multiprocessing` does, so programs need no `if __name__ == "__main__":`; what they define is
# sent to it by value.
CHILD = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from egad._util.child_process import serve; serve(int(sys.argv[2]))"
)


class Worker:
    """Work in a process of its own, which can die or be stopped; the next item starts a new one."""

    def __init__(
        self,
        make_work: MakeWork,
        limit: float | None = None,
        start_limit: float | None = None,
        name: str = "a worker process",
        environment: Mapping[str, str] | None = None,
        quiet: bool = False,
    ) -> None:
        """Prepare; `make_work` is a context manager that gives the function; limits are seconds."""
        self._environment, self._quiet = environment or {}, quiet
        self._make_work, self._limit, self._start_limit = make_work, limit, start_limit
        self._name = name
        self._process: subprocess.Popen[bytes] | None = None
        self._killed = False

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def running(self) -> bool:
        """Whether there is a process; if not, the next item starts one."""
        return self._process is not None

    def __call__(self, item: Any) -> Any:  # noqa: ANN401 (whatever the work takes and gives)
        """Do the work on one item; raise what it raises, or a `Worker...Error` for its process."""
        message = to_bytes(item)
        if not (self.running or self._killed):
            self.start()
        if self._killed:
            raise WorkerDiedError(f"{self._name} has been stopped")
        try:
            self._pipe.send_bytes(message)
            if not self._pipe.poll(self._limit):
                self.stop(patience=0)
                raise WorkerTimeoutError(f"{self._name} did not answer within {self._limit:g} s")
            answer = self._pipe.recv_bytes()
        except (EOFError, OSError) as gone:
            raise WorkerDiedError(self._ending()) from gone
        return _result(answer)

    def start(self) -> None:
        """Start the process; `UserError` if it does not, or what `make_work` raises."""
        message = to_bytes(self._make_work)
        self._pipe, theirs = multiprocessing.Pipe()
        end, self._lifeline = multiprocessing.Pipe(duplex=False)
        where = json.dumps([path for path in sys.path if isinstance(path, str)])
        with theirs, end:
            self._process = subprocess.Popen(  # noqa: S603
                [sys.executable, "-c", CHILD, where, str(theirs.fileno())],
                env={**os.environ, **self._environment},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL if self._quiet else None,
                stderr=subprocess.DEVNULL if self._quiet else None,
                pass_fds=[theirs.fileno(), end.fileno()],
            )
            kill_when_closed(end, self._process.pid)
        try:
            self._pipe.send_bytes(message)
            if not self._pipe.poll(self._start_limit):
                self.stop(patience=0)
                raise UserError(f"{self._name} was not ready within {self._start_limit:g} s")
            answer = self._pipe.recv_bytes()
        except (EOFError, OSError) as gone:
            raise UserError(f"{self._ending()} while it started") from gone
        try:
            _result(answer)
        except Exception:
            self.stop()
            raise

    def _ending(self) -> str:
        """How a process that no longer answers ended, in words, or `WorkerKilledError`."""
        status = self.stop()
        if status == -signal.SIGKILL:
            raise WorkerKilledError(
                f"{self._name} was killed, probably {out_of_memory()}; {LESS_MEMORY}"
            )
        ending = f"{self._name} {'hung up' if status is None else f'ended with status {status}'}"
        if status and (memory_limit() or MAX_MEMORY) < MAX_MEMORY:
            return f"{ending}, perhaps {out_of_memory()}"
        return ending

    def close_pipe(self) -> None:
        """Let the process end by itself, without waiting: it can receive no more requests."""
        if self.running:
            self._pipe.close()

    def stop(self, patience: float = ENDING_TIME) -> int | None:
        """End the process; returns its status if it ends by itself within `patience` seconds."""
        self.close_pipe()
        process, self._process = self._process, None
        if process is None:
            return None
        try:
            return process.wait(patience)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            return None
        finally:
            self._lifeline.close()

    def kill(self) -> None:
        """End the process for good, even if another thread is waiting for its answer."""
        self._killed = True
        if process := self._process:
            process.kill()


def one_thread() -> threadpool_limits:
    """Limit algebra to one thread: otherwise each process has one per core, and they wait."""
    import scipy.linalg  # noqa: F401, PLC0415 (only libraries that are loaded can be limited)

    return threadpool_limits(1)


def kill_when_closed(end: Connection, process: int) -> None:
    """Have Linux kill a process (a negative number: a group) once nobody can write to `end`."""
    with suppress(OSError):  # not in every sandbox
        fcntl.fcntl(end, fcntl.F_SETSIG, signal.SIGKILL)
        fcntl.fcntl(end, fcntl.F_SETOWN, process)
        fcntl.fcntl(end, fcntl.F_SETFL, os.O_ASYNC)


def serve(number: int) -> None:
    """Work for the other end of a pipe until it is closed; the first message makes the work."""
    with Connection(number) as pipe, ExitStack() as stack, suppress(EOFError):
        first = pipe.recv_bytes()
        try:
            work = stack.enter_context(from_bytes(first)())
        except Exception as error:
            pipe.send_bytes(_failure(error))
            return
        pipe.send_bytes(_dumps((None, None, None)))
        while True:
            item = pipe.recv_bytes()
            try:
                answer = _dumps((work(from_bytes(item)), None, None))
            except Exception as error:
                answer = _failure(error)
            pipe.send_bytes(answer)


def _result(answer: bytes) -> Any:  # noqa: ANN401 (whatever the work gives)
    """The result in an answer; raises the error in it."""
    result, error, origin = from_bytes(answer)
    if error is not None:
        raise error from origin
    return result


class _Pickler(cloudpickle.CloudPickler):  # type: ignore[misc]
    """Sends what the program defines by value, cached functions with an empty cache."""

    def reducer_override(self, obj: Any) -> Any:  # noqa: ANN401 (any object, any reduction)
        if _is_module_of_own_class(obj):
            return importlib.import_module, (obj.__name__,)
        if isinstance(obj, CACHED) and not _is_importable(obj):
            attributes = {k: v for k, v in vars(obj).items() if k != "cache_parameters"}
            return _with_cache, (obj.__wrapped__, obj.cache_parameters()), attributes
        return super().reducer_override(obj)


def _is_module_of_own_class(obj: object) -> TypeGuard[ModuleType]:
    """Whether it is a module that cloudpickle does not know as one: `egad`, which loads lazily."""
    if not isinstance(obj, ModuleType) or type(obj) is ModuleType:
        return False
    return sys.modules.get(obj.__name__) is obj


def _is_importable(function: Any) -> bool:  # noqa: ANN401 (its type is private)
    """Whether another process finds a function by its name, as it does in modules."""
    try:
        module, name = function.__module__, function.__qualname__
        return module != "__main__" and attrgetter(name)(sys.modules[module]) is function
    except (KeyError, AttributeError):
        return False


def _with_cache(function: Callable[..., Any], parameters: dict[str, Any]) -> Callable[..., Any]:
    cached: Callable[..., Any] = functools.lru_cache(**parameters)(function)
    return cached


def _dumps(what: Any) -> bytes:  # noqa: ANN401 (all that is sent)
    file = io.BytesIO()
    _Pickler(file).dump(what)
    return file.getvalue()


def to_bytes(what: Any) -> bytes:  # noqa: ANN401 (whatever the work takes, or what makes it)
    """Pickle something for another process; `UserError` if it cannot be pickled."""
    try:
        return _dumps(what)
    except (pickle.PicklingError, AttributeError, TypeError, ValueError) as error:
        raise UserError(f"{NOT_SENT}: {error}") from error


def from_bytes(sent: bytes) -> Any:  # noqa: ANN401 (as above)
    """Unpickle what another process sent; `UserError` if this process lacks a module or name."""
    try:
        return pickle.loads(sent)  # noqa: S301 (our own)
    except (ImportError, AttributeError) as error:
        raise UserError(f"{NOT_SENT}: {error}") from error


def _failure(error: Exception) -> bytes:
    """An error as an answer, with its traceback unless its text was written for a person."""
    trace = "".join(traceback.format_exception(error))
    origin = None if isinstance(error, EgadError) else _RemoteError(f"\n{trace}")
    return _dumps((None, _portable(error), origin))


def _portable(error: Exception) -> Exception:
    """An error as it is if it can be sent; else one with its text."""
    try:
        pickle.loads(_dumps(error))  # noqa: S301 (our own)
    except Exception:
        for kind in (UserError, RejectedError):
            if isinstance(error, kind):
                return kind(str(error))
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
