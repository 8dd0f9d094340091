"""Work spread over processes, in an order and with results that do not depend on how many."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from typing import Any

Mapper = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]


@contextmanager
def workers(count: int) -> Iterator[Mapper]:
    """A `map` that keeps order and runs in `count` processes (in this one if 1)."""
    if count == 1:
        yield map
        return
    with ProcessPoolExecutor(count) as pool:
        yield partial(pool.map, chunksize=2)
