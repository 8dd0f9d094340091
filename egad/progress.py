"""Progress of long work: a bar on a terminal, a plain line every half minute in a log."""

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from rich.console import Console
from rich.progress import Progress, TextColumn

T = TypeVar("T")
LOG_INTERVAL = 30.0


def progress(
    items: Iterable[T],
    what: str,
    total: int,
    *,
    scale: int = 1,
    state: Callable[[], str] = lambda: "",
) -> Iterator[T]:
    """Pass items through and show on stderr how far the work is.

    Args:
        items: Things to work on.
        what: What the work is, e.g. `"grading objects"`.
        total: How many items there are.
        scale: What an item counts, for instance the evaluations of a step.
        state: Says how the work stands, e.g. `"coverage 0.81"`; nothing by default.

    Yields:
        The items, unchanged and in order.
    """
    console = Console(stderr=True)
    if console.is_terminal:
        yield from _bar(items, what, total, scale, state, console)
    else:
        yield from _lines(items, what, total, scale, state)


def _bar(
    items: Iterable[T],
    what: str,
    total: int,
    scale: int,
    state: Callable[[], str],
    console: Console,
) -> Iterator[T]:
    speed = TextColumn("{task.fields[rate]}")
    columns = (*Progress.get_default_columns(), speed, TextColumn("{task.fields[state]}"))
    start = time.monotonic()
    with Progress(*columns, console=console) as bar:
        task = bar.add_task(what, total=total, rate="", state="")
        for done, item in enumerate(items, 1):
            yield item
            rate = scale * done / max(time.monotonic() - start, 1e-9)
            bar.update(task, completed=done, rate=f"{rate:.1f}/s", state=state())


def _lines(
    items: Iterable[T], what: str, total: int, scale: int, state: Callable[[], str]
) -> Iterator[T]:
    start = last = time.monotonic()
    for done, item in enumerate(items, 1):
        yield item
        now = time.monotonic()
        if now - last >= LOG_INTERVAL:
            last = now
            rate = done / (now - start)
            parts = [
                f"{what}: {scale * done}/{scale * total}",
                f"{scale * rate:.1f}/s",
                f"{(total - done) / rate:.0f} s left",
                state(),
            ]
            print(", ".join(part for part in parts if part), file=sys.stderr)
