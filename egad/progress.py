"""Progress of long work: a bar on a terminal, a plain line every half minute in a log."""

import sys
import time
from collections.abc import Iterable, Iterator
from typing import TypeVar

from rich.console import Console
from rich.progress import track

T = TypeVar("T")
LOG_INTERVAL = 30.0


def progress(items: Iterable[T], what: str, total: int) -> Iterator[T]:
    """Pass items through and show on stderr how far the work is.

    Args:
        items: Things to work on.
        what: What the work is, e.g. `"grading objects"`.
        total: How many items there are.

    Yields:
        The items, unchanged and in order.
    """
    console = Console(stderr=True)
    if console.is_terminal:
        yield from track(items, what, total=total, console=console)
        return
    start = last = time.monotonic()
    for done, item in enumerate(items, 1):
        yield item
        now = time.monotonic()
        if now - last >= LOG_INTERVAL:
            last = now
            rate = done / (now - start)
            left = (total - done) / rate
            print(f"{what}: {done}/{total}, {rate:.1f}/s, {left:.0f} s left", file=sys.stderr)
