"""Compiled functions: `kernel` has numba compile a function, cache its code, and report it."""

import fcntl
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any, TypeVar
from zlib import crc32

import numba
from numba.core import event
from numba.core.compiler_lock import global_compiler_lock

from egad._util.kernel_cache import kernel_folder
from egad._util.progress import phase

PACKAGE = __name__.partition(".")[0]
REPORT = 1 << 32  # a byte that no kernel has
Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(**options: Any) -> Callable[[Function], Function]:  # noqa: ANN401 (of numba)
    """Compile a function at its first call; its machine code is kept in `kernel_folder`.

    numba decides where it keeps the code of a function when it decorates it. Functions of other
    packages in the same process are kept where those want. A process that needs a kernel waits
    while another compiles it.

    Args:
        options: See `numba.njit`.
    """

    def decorate(function: Function) -> Function:
        config: Any = numba.config
        before, config.CACHE_DIR = config.CACHE_DIR, str(kernel_folder())
        try:
            compiled: Any = numba.njit(cache=True, **options)(function)
        finally:
            config.CACHE_DIR = before
        compile_or_load = compiled.compile

        def compile_once(signature: object) -> object:
            with global_compiler_lock, _reserved(f"{function.__module__}.{function.__qualname__}"):
                return compile_or_load(signature)

        compiled.compile = compile_once
        result: Function = compiled
        return result

    return decorate


@contextmanager
def _reserved(name: str) -> Iterator[None]:
    """Keep other processes from compiling a kernel, where the file system has locks."""
    byte = crc32(name.encode())
    with suppress(OSError):
        fcntl.lockf(_locks(), fcntl.LOCK_EX, 1, byte)
    try:
        yield
    finally:
        with suppress(OSError):
            fcntl.lockf(_locks(), fcntl.LOCK_UN, 1, byte)


@cache
def _locks() -> int:
    """A file with a byte for each kernel, open as long as this process: closing it ends locks."""
    return os.open(kernel_folder() / "locks", os.O_RDWR | os.O_CREAT, 0o666)


class _Compilation(event.Listener):
    """Reports on stderr that kernels are being compiled, once for all processes of a command."""

    def __init__(self) -> None:
        self._reported = False

    def on_start(self, what: event.Event) -> None:
        """Report the first kernel of ours."""
        module: str = what.data["dispatcher"].py_func.__module__
        if not self._reported and module.partition(".")[0] == PACKAGE:
            self._reported = True
            if _is_first():
                phase("compiling kernels, which happens once and takes about half a minute")

    def on_end(self, _: event.Event) -> None:
        """Report nothing."""


def _is_first() -> bool:
    """Whether no other process reports, and none of the same command has done so before."""
    with suppress(OSError):
        try:
            fcntl.lockf(_locks(), fcntl.LOCK_EX | fcntl.LOCK_NB, 1, REPORT)  # until this one ends
        except BlockingIOError:
            return False
    command = f"{os.getpgid(0):20}".encode()
    before = os.pread(_locks(), len(command), 0)
    os.pwrite(_locks(), command, 0)
    return before != command


event.register("numba:compile", _Compilation())
