"""Work spread over processes, in an order and with results that do not depend on how many."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from typing import Any

from egad.errors import UserError

Mapper = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]


@contextmanager
def workers(count: int) -> Iterator[Mapper]:
    """A `map` that keeps order and runs in `count` processes (in this one if 1)."""
    if count == 1:
        yield map
        return
    try:
        with ProcessPoolExecutor(count) as pool:
            yield partial(pool.map, chunksize=2)
    except BrokenProcessPool as error:
        raise UserError(
            "a worker process was killed, probably for want of memory; take fewer with --jobs"
        ) from error
