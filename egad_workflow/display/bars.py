"""Jobs as bars at the bottom of a terminal; printed text appears above them."""

import time
from typing import TextIO, cast

from rich.console import Console, Group, RenderableType
from rich.file_proxy import FileProxy
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from egad._util.progress import Status, duration, rate_text
from egad_workflow.display.jobs import Job, Run

REFRESH = 2  # times a second
WIDTH = 20  # columns of a bar
MARGIN = 4  # rows of the terminal left free


class Bars:
    """Draws two rows for each job and one for the whole run."""

    def __init__(self, run: Run, stream: TextIO) -> None:
        self._run, self._start = run, time.monotonic()
        self._console = Console(file=stream, force_terminal=True)
        self.stream = cast("TextIO", FileProxy(self._console, stream))
        self._live = Live(
            console=self._console,
            get_renderable=self._rows,
            refresh_per_second=REFRESH,
            transient=True,
            redirect_stdout=False,
            redirect_stderr=False,
        )
        self._live.start()

    def print(self, text: str, style: str = "") -> None:
        """Print lines that stay, above the bars."""
        self._console.print(Text(text, style), soft_wrap=True)

    def close(self) -> None:
        """Remove the bars."""
        self._live.stop()

    def _rows(self) -> RenderableType:
        running, now = self._run.running(), time.monotonic()
        fitting = max((self._console.height - MARGIN) // 2, 1)
        rows = [row for job in running[:fitting] for row in _job_rows(job, now)]
        done, total = self._run.steps
        words = [f"{done} of {total} steps", f"{len(running)} running", duration(now - self._start)]
        return Group(*rows, _row(ProgressBar(total, done, WIDTH), words))


def _job_rows(job: Job, now: float) -> list[RenderableType]:
    status, doing = job.read()
    title = Text(f"{job.rule}: {job.message}", "bold", no_wrap=True, overflow="ellipsis")
    parts = [*(_words(status) if status else []), doing, f"{duration(now - job.start)} so far"]
    return [title, _row(_bar(status), [part for part in parts if part])]


def _bar(status: Status | None) -> ProgressBar:
    if status is None:
        return ProgressBar(None, width=WIDTH)
    return ProgressBar(status.total, status.done, WIDTH)


def _words(status: Status) -> list[str]:
    counts = f"{status.done}/{status.total} {status.what}"
    rate = rate_text(status.rate) if status.rate else ""
    return [counts, rate, f"{duration(status.left)} left" if status.left else "", status.state]


def _row(bar: ProgressBar, words: list[str]) -> Table:
    row = Table.grid(padding=(0, 1), expand=True)
    row.add_column(width=WIDTH)
    row.add_column(ratio=1, no_wrap=True, overflow="ellipsis")
    row.add_row(bar, ", ".join(words))
    return row
