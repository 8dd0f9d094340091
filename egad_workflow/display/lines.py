"""Jobs as plain lines, for a pipe, a file or a continuous integration server."""

import threading
import time
from collections.abc import Iterator
from typing import TextIO

from egad._util.progress import PEOPLE, duration
from egad_workflow.display.jobs import Job, Run

TICK = 0.5
MAX_LINES = 10  # jobs with their own lines; further jobs are only counted


class Lines:
    """Prints a line for each job, now and then."""

    def __init__(self, run: Run, stream: TextIO) -> None:
        self.stream, self._run = stream, run
        self._last: dict[Job, float] = {}  # when a line was printed
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def print(self, text: str, style: str = "") -> None:  # noqa: ARG002 (plain text has none)
        """Print lines that stay."""
        self.stream.write(f"{text}\n")
        self.stream.flush()

    def close(self) -> None:
        """Show nothing more."""
        self._ended.set()
        self._thread.join()

    def _watch(self) -> None:
        while not self._ended.wait(TICK):
            if lines := list(self._lines(time.monotonic())):
                self.print("\n".join(lines))

    def _lines(self, now: float) -> Iterator[str]:
        running = self._run.running()
        self._last = {job: self._last.get(job, job.start) for job in running}
        due = [
            job
            for job in running[:MAX_LINES]
            if now - self._last[job] >= PEOPLE.pause(now - job.start)
        ]
        for job in due:
            self._last[job] = now
            yield f"{clock()}       {job_line(job, now)}"
        if due and len(running) > MAX_LINES:
            yield f"{clock()}       and {len(running) - MAX_LINES} more jobs"


def job_line(job: Job, now: float) -> str:
    """The progress of a job."""
    status, doing = job.read()
    parts = [str(status) if status else "", doing, f"{duration(now - job.start)} so far"]
    return f"{job.message}: {', '.join(part for part in parts if part)}"


def clock() -> str:
    """The time of day."""
    return time.strftime("%H:%M:%S")
