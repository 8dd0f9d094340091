"""Compiled functions: `kernel` has numba compile a function, cache its code, and report it."""

import fcntl
import hashlib
import logging
import os
import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, partial
from typing import Any, TypeVar
from zlib import crc32

import numba
from numba.core import event
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.compiler_lock import global_compiler_lock
from numba.core.serialize import dumps

from egad._util.kernel_cache import kernel_folder
from egad._util.progress import phase

PACKAGE = __name__.partition(".")[0]
REPORT = 1 << 32  # a byte that no kernel has
log = logging.getLogger(__name__)
Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(**options: Any) -> Callable[[Function], Function]:  # noqa: ANN401 (of numba)
    """Compile a function, as `numba.njit`, at its first call; its code is kept in `kernel_folder`.

    Only these kernels are kept there. A process waits while another compiles a kernel that it
    needs.
    """

    def decorate(function: Function) -> Function:
        config: Any = numba.config
        before, config.CACHE_DIR = config.CACHE_DIR, str(kernel_folder())
        try:
            compiled: Any = numba.njit(**options)(function)
            compiled._cache = _Cache(function)  # noqa: SLF001 (numba has no other way)
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


class _CheckedCode(CompileResultCacheImpl):
    """Machine code with a checksum: what is damaged would be run as well."""

    def reduce(self, cres: Any) -> tuple[bytes, bytes]:  # noqa: ANN401 (of numba)
        code = dumps(super().reduce(cres))
        return hashlib.sha256(code).digest(), code

    def rebuild(self, target_context: Any, payload: tuple[bytes, bytes]) -> Any:  # noqa: ANN401
        checksum, code = payload
        if hashlib.sha256(code).digest() != checksum:
            raise ValueError("damaged")
        return super().rebuild(target_context, pickle.loads(code))  # noqa: S301 (our own)


class _Cache(FunctionCache):
    """A cache without which a function works too: damaged code is compiled and written again."""

    _impl_class = _CheckedCode

    def load_overload(self, sig: Any, target_context: Any) -> Any:  # noqa: ANN401 (of numba)
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # damaged files may raise anything
            self._or_warn(self.flush)
            return None

    def save_overload(self, sig: Any, data: Any) -> None:  # noqa: ANN401 (of numba)
        self._or_warn(partial(super().save_overload, sig, data))

    def _or_warn(self, write: Callable[[], None]) -> None:
        try:
            write()
        except OSError as error:
            self.disable()
            _warn_not_kept(self.cache_path, error.strerror)


@cache
def _warn_not_kept(folder: str, reason: str) -> None:
    log.warning("%s: compiled kernels cannot be kept: %s", folder, reason)


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
    command = f"{os.getpgid(0):20}".encode()
    try:
        fcntl.lockf(_locks(), fcntl.LOCK_EX | fcntl.LOCK_NB, 1, REPORT)  # until this one ends
        before = os.pread(_locks(), len(command), 0)
        os.pwrite(_locks(), command, 0)
    except BlockingIOError:
        return False
    except OSError:  # without locks, or on a full disk
        return True
    return before != command


event.register("numba:compile", _Compilation())
