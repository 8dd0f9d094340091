"""Work spread over processes, in an order and with results that do not depend on how many."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from typing import Any

from threadpoolctl import threadpool_limits

from egad.errors import UserError

Mapper = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]


@contextmanager
def workers(count: int) -> Iterator[Mapper]:
    """A `map` that keeps order and runs in `count` processes (in this one if 1)."""
    if count == 1:
        with _one_thread():
            yield map
        return
    try:
        with ProcessPoolExecutor(count, initializer=_one_thread) as pool:
            yield partial(pool.map, chunksize=2)
    except BrokenProcessPool as error:
        raise UserError(
            "a worker process was killed, probably for want of memory; take fewer with --jobs"
        ) from error


def _one_thread() -> threadpool_limits:
    """Algebra in one thread: else each process has one for every core, and they wait."""
    import scipy.linalg  # noqa: F401, PLC0415 (only libraries that are loaded can be limited)

    return threadpool_limits(1)
