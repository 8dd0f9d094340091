"""Progress of long work: a bar on a terminal or in a notebook, else lines that can be read back."""

import importlib
import os
import re
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, Self, TypeVar

T = TypeVar("T")
RATE_UNITS = {"s": 1, "min": 60, "h": 3600}
LINE = re.compile(
    r"(?P<what>\S.*?): (?P<done>\d+)/(?P<total>\d+)"
    r"(?:, (?P<rate>[\d.]+)/(?P<unit>s|min|h))?(?:, [\d:]+ left)?(?:, (?P<state>.+))?"
)
PHASE_END = " ..."
MARK = "! "
MARKS = "EGAD_MARKS"  # set in the environment of the jobs of the workflow
SLOW = 3.0  # seconds
BAR_WIDTH, FULL, EMPTY = 20, "\N{FULL BLOCK}", "\N{LIGHT SHADE}"
WINDOW, STEADY = 60.0, 5.0  # seconds that a rate is taken over: at most, and at least
ENOUGH = 2  # items that a rate is taken over, at least
POLLING = 0.5  # seconds between two looks at what other processes have done
BURST = 0.05  # seconds; items that come within this time were done together


class Pace(NamedTuple):
    """Seconds between two lines: a share of the time the work has taken so far, within limits."""

    shortest: float
    longest: float
    share: float

    def pause(self, taken: float) -> float:
        """Seconds until the next line, from those that the work has taken."""
        return min(max(self.share * taken, self.shortest), self.longest)


LOG, NOTEBOOK, TERMINAL = Pace(1.0, 10.0, 0.1), Pace(1.0, 1.0, 0.0), Pace(0.0, 0.0, 0.0)
PEOPLE = Pace(15.0, 60.0, 0.5)  # who read all lines; short work has none


@dataclass(frozen=True)
class Status:
    """How far some work is."""

    what: str  # what the work is, e.g. `"evaluations"`
    done: int  # how much is done
    total: int  # how much there is to do
    rate: float = 0.0  # how much is done in a second; 0 if that is not known yet
    state: str = ""  # more words, e.g. `"coverage 0.81"`

    @property
    def left(self) -> float | None:
        """Seconds until the end at this rate; None without a rate."""
        return max(self.total - self.done, 0) / self.rate if self.rate > 0 else None

    @property
    def words(self) -> str:
        """All but what the work is."""
        rate = rate_text(self.rate) if self.rate > 0 else ""
        left = f"{duration(self.left)} left" if self.left else ""
        return ", ".join(filter(None, [f"{self.done}/{self.total}", rate, left, self.state]))

    def __str__(self) -> str:
        return f"{self.what}: {self.words}"

    @classmethod
    def parse(cls, line: str) -> Self | None:
        """The inverse of `str`; None for a line that tells no progress."""
        found = LINE.fullmatch(line)
        if found is None:
            return None
        rate = float(found["rate"] or 0) / RATE_UNITS[found["unit"] or "s"]
        done, total = int(found["done"]), int(found["total"])
        return cls(found["what"], done, total, rate, found["state"] or "")


def duration(seconds: float) -> str:
    """A time as `M:SS` or `H:MM:SS`."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


def rate_text(rate: float) -> str:
    """A rate in the first unit of time in which it is at least 1, with three digits or more."""
    unit, seconds = next(
        (unit for unit in RATE_UNITS.items() if rate * unit[1] >= 1), ("h", RATE_UNITS["h"])
    )
    value = rate * seconds
    return f"{value:.{2 if value < 10 else 1 if value < 100 else 0}f}/{unit}"


def progress(
    items: Iterable[T],
    what: str,
    total: int,
    *,
    scale: int = 1,
    state: Callable[[], str] = lambda: "",
) -> Iterator[T]:
    """Pass items through, each counted `scale` times, and show how far the work is."""
    if sys.stderr.isatty():
        with _bar(what, scale * total) as draw:
            yield from _lines(items, what, total, scale, state, draw, TERMINAL)
    elif write := _notebook_line():
        yield from _lines(items, what, total, scale, state, write, NOTEBOOK)
    else:
        pace = LOG if MARKS in os.environ else PEOPLE
        yield from _lines(items, what, total, scale, state, _write, pace)


@contextmanager
def shared_progress(what: str, total: int) -> Iterator[Path]:
    """Show the progress of work done elsewhere, or in long calls: a file for `count_done`."""
    stop = threading.Event()
    with TemporaryDirectory() as folder:
        file = Path(folder) / "done"
        file.touch()
        shown = progress(_counted(file, total, stop), what, total)
        thread = threading.Thread(target=deque, args=(shown, 0), daemon=True)
        thread.start()
        try:
            yield file
        finally:
            stop.set()
            thread.join()


def count_done(file: Path, number: int) -> None:
    """Add to what is done; several processes may do so at once."""
    with file.open("ab") as out:
        out.write(bytes(number))


def _counted(file: Path, total: int, stop: threading.Event) -> Iterator[None]:
    """One item for each byte of the file, as soon as it is there."""
    shown, ended = 0, False
    while shown < total and not ended:
        ended = stop.wait(POLLING)
        done = min(file.stat().st_size, total)
        yield from repeat(None, done - shown)
        shown = done


def phase(what: str) -> None:
    """Say on stderr what is being done now, for work whose progress is not known."""
    print(f"{what}{PHASE_END}", file=sys.stderr, flush=True)


@contextmanager
def phase_if_slow(what: str) -> Iterator[None]:
    """Say on stderr what a block or function is doing, if it takes more than a few seconds."""
    timer = threading.Timer(SLOW, phase, [what])
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def parse_phase(line: str) -> str:
    """The words that `phase` was given; empty for any other line."""
    return line.removesuffix(PHASE_END) if line.endswith(PHASE_END) else ""


def marked(text: str) -> str:
    """Lines for a log that also reach the terminal of the workflow."""
    return "\n".join(f"{MARK}{line}" for line in text.splitlines())


def parse_marked(line: str) -> str | None:
    """A line that `marked` was given; None for any other."""
    return line.removeprefix(MARK) if line.startswith(MARK) else None


class _Meter:
    """A rate over the last minute, without the first item, which may have to compile kernels."""

    def __init__(self) -> None:
        self._marks: deque[tuple[float, int]] = deque()  # moments, and what was done then

    def rate(self, now: float, done: int) -> float:
        """Items per second, from the number that are done at a given time; 0: not known yet."""
        marks = self._marks
        if marks and now - marks[-1][0] < BURST:
            marks[-1] = marks[-1][0], done
        elif not marks or now - marks[-1][0] >= LOG.shortest:
            marks.append((now, done))
        while len(marks) > 1 and marks[1][0] < now - WINDOW:
            marks.popleft()
        since, before = marks[0]
        known = now - since >= STEADY and done - before >= ENOUGH
        return (done - before) / (now - since) if known else 0.0


@contextmanager
def _bar(what: str, total: int) -> Iterator[Callable[[Status], None]]:
    from rich.console import Console  # noqa: PLC0415 (jobs have no terminal)
    from rich.progress import Progress, TextColumn  # noqa: PLC0415

    name, bar, percentage, _ = Progress.get_default_columns()
    columns = name, bar, percentage, TextColumn("{task.fields[words]}")
    with Progress(*columns, console=Console(stderr=True)) as shown:
        task = shown.add_task(what, total=total, words="")
        yield lambda status: shown.update(task, completed=status.done, words=status.words)


def _lines(
    items: Iterable[T],
    what: str,
    total: int,
    scale: int,
    state: Callable[[], str],
    write: Callable[[Status], None],
    pace: Pace,
) -> Iterator[T]:
    start = last = time.monotonic()
    meter = _Meter()
    if said := pace is not PEOPLE:
        write(Status(what, 0, scale * total))
    for done, item in enumerate(items, 1):
        yield item
        now = time.monotonic()
        rate = scale * meter.rate(now, done)
        if (said and done == total) or now - last >= pace.pause(now - start):
            said, last = True, now
            write(Status(what, scale * done, scale * total, rate, state()))


def _notebook_line() -> Callable[[Status], None] | None:
    """A function that shows a status in a line of a notebook and updates it; None elsewhere."""
    shell: Any = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if getattr(shell, "kernel", None) is None:
        return None
    display: Any = importlib.import_module("IPython.display").display
    line = display({"text/plain": ""}, raw=True, display_id=True)

    def write(status: Status) -> None:
        done = BAR_WIDTH * status.done // max(status.total, 1)
        bar = FULL * done + EMPTY * (BAR_WIDTH - done)
        line.update({"text/plain": f"{bar} {status}"}, raw=True)

    return write


def _write(status: Status) -> None:
    if status.total:
        print(status, file=sys.stderr, flush=True)
