"""Compiled functions: `kernel` has numba compile a function, cache its code, and report it."""

import time
from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.core import event

from egad._util.kernel_cache import kernel_folder
from egad._util.progress import phase

PACKAGE = __name__.partition(".")[0]
REPEAT = 30.0  # seconds
Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(**options: Any) -> Callable[[Function], Function]:  # noqa: ANN401 (of numba)
    """Compile a function at its first call; its machine code is kept in `kernel_folder`.

    numba decides where it keeps the code of a function when it decorates it. Functions of other
    packages in the same process are kept where those want.

    Args:
        options: See `numba.njit`.
    """

    def decorate(function: Function) -> Function:
        config: Any = numba.config
        before, config.CACHE_DIR = config.CACHE_DIR, str(kernel_folder())
        try:
            compiled: Function = numba.njit(cache=True, **options)(function)
        finally:
            config.CACHE_DIR = before
        return compiled

    return decorate


class _Compilation(event.Listener):
    """Reports on stderr that kernels are being compiled, and again while that goes on."""

    def __init__(self) -> None:
        self._said = -REPEAT

    def on_start(self, what: event.Event) -> None:
        """Report a kernel of ours, unless one was reported a short time ago."""
        module: str = what.data["dispatcher"].py_func.__module__
        if module.partition(".")[0] == PACKAGE and time.monotonic() - self._said >= REPEAT:
            self._said = time.monotonic()
            phase("compiling kernels, at their first use only")

    def on_end(self, _: event.Event) -> None:
        """Report nothing."""


event.register("numba:compile", _Compilation())
