"""The running jobs, and the progress of each according to its log."""

import os
import time
from dataclasses import dataclass, field
from pathlib import Path

from egad._util.progress import Status, parse_phase

READ_BYTES = 32768  # of the end of a log
SILENCE = 30.0  # seconds without any output after which a job no longer counts as starting


@dataclass(eq=False)
class Job:
    """A running job."""

    rule: str
    message: str  # what it does
    log: Path | None  # its log, if it has one
    start: float = field(default_factory=time.monotonic)  # when it started, by the monotonic clock
    _former: tuple[int, int] | None = field(init=False)

    def __post_init__(self) -> None:
        self._former = self._written()  # left by an earlier run

    def read(self) -> tuple[Status | None, str]:
        """The last progress in its log, and a description of what it has done since."""
        if self.log is None or self._written() in (None, self._former):
            silent = time.monotonic() - self.start > SILENCE
            return None, "no output yet" if silent else "starting"
        return last_progress(last_lines(self.log))

    def _written(self) -> tuple[int, int] | None:
        try:
            status = self.log.stat() if self.log else None
        except OSError:
            return None
        return (status.st_mtime_ns, status.st_size) if status else None


@dataclass
class Run:
    """The steps of a run, done and in all, and its running jobs by their numbers in Snakemake."""

    steps: tuple[int, int]
    jobs: dict[int, Job] = field(default_factory=dict)

    def running(self) -> list[Job]:
        """All jobs in the order in which they started; another thread may add to them."""
        return list(self.jobs.values())


def last_progress(lines: list[str]) -> tuple[Status | None, str]:
    """The last progress in a log, unless it is complete, and the phase that started after it."""
    doing = ""
    for line in reversed(lines):
        if status := Status.parse(line):
            return (None if doing and status.done >= status.total else status), doing
        doing = doing or parse_phase(line)
    return None, doing or "starting"


def last_lines(log: Path) -> list[str]:
    """The last lines of a log, the first of which may be cut off; empty if there is no log."""
    try:
        with log.open("rb") as file:
            file.seek(max(file.seek(0, os.SEEK_END) - READ_BYTES, 0))
            return file.read().decode("utf-8", errors="replace").splitlines()
    except OSError:
        return []
