"""Messages from Snakemake to its log handlers, shortened for the terminal.

Messages without a shorter form reach the terminal as they are. Snakemake's own log file has all of
them in full.
"""

import logging
import os
import re
import time
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from egad._util.progress import duration, parse_marked
from egad_workflow.display.jobs import Job, Run, last_lines
from egad_workflow.display.lines import Lines, clock

if TYPE_CHECKING:
    from egad_workflow.display.bars import Bars

LOGGER = logging.getLogger("snakemake.logging")
SNAKEMAKE_HANDLER = "DefaultStreamHandler"
QUIET = {"ALL", "RULES", "PROGRESS"}
REPLACED = ("job_info", "job_started", "job_finished", "progress", "job_error")
SELECTING = "Select jobs to execute..."
COMMAND = re.compile(r"^Command '.*' (?=returned |died )", re.DOTALL | re.MULTILINE)
ERROR_LINES = 20
FAILURE, CAUTION = "bold red", "yellow"


def start_display(steps: int, whole_logs: Collection[str] = ()) -> None:
    """Show the jobs of this run until Snakemake closes its log handlers, unless it is quiet."""
    for handler in [each for each in LOGGER.handlers if isinstance(each, Display)]:
        LOGGER.removeHandler(handler)
        handler.close()
    terminal = next((each for each in LOGGER.handlers if each.name == SNAKEMAKE_HANDLER), None)
    if isinstance(terminal, logging.StreamHandler) and not _is_quiet(terminal):
        LOGGER.addHandler(Display(terminal, steps, whole_logs))


def _is_quiet(handler: logging.Handler) -> bool:
    asked = (each for part in handler.filters for each in getattr(part, "quiet", None) or ())
    return any(each.name in QUIET for each in asked)


class Display(logging.Handler):
    """Shows the jobs that Snakemake's messages are about."""

    def __init__(
        self,
        terminal: "logging.StreamHandler[TextIO]",
        steps: int,
        whole_logs: Collection[str] = (),
    ) -> None:
        """Start to show jobs in place of `terminal`; the rest as in `start_display`."""
        super().__init__()
        self._run = Run((0, steps))
        self._done: list[Job] = []  # done, but not printed yet
        self._terminal, self._stream, self._whole_logs = terminal, terminal.stream, whole_logs
        self._view = _view(self._run, terminal.stream)
        terminal.setStream(self._view.stream)
        terminal.addFilter(_is_kept)

    def close(self) -> None:
        """Leave the terminal as it was."""
        self._view.close()
        self._terminal.removeFilter(_is_kept)
        self._terminal.setStream(self._stream)
        super().close()

    def emit(self, record: logging.LogRecord) -> None:
        """Show what a message says, if it is about a job."""
        shown = {
            "job_info": self._start,
            "job_finished": self._finish,
            "progress": self._count,
            "job_error": self._fail,
            "group_error": self._fail_group,
            "error": self._explain,
        }
        try:
            if show := shown.get(str(getattr(record, "event", ""))):
                show(record.__dict__)
        except Exception:
            self.handleError(record)

    def _start(self, message: dict[str, Any]) -> None:
        if not message["log"]:
            return  # a target that only asks for files
        log = Path(message["log"][0])
        job = Job(message["rule_name"], message["rule_msg"] or message["rule_name"], log)
        self._run.jobs[message["jobid"]] = job
        self._view.print(f"{clock()} start {job.rule}: {job.message}")

    def _finish(self, message: dict[str, Any]) -> None:
        if job := self._run.jobs.pop(message["job_id"], None):
            self._done.append(job)

    def _count(self, message: dict[str, Any]) -> None:
        """Print which jobs are done; this message comes after those of the jobs."""
        self._run.steps = message["done"], message["total"]
        steps = f"({message['done']} of {message['total']} steps)"
        for job in self._done:
            taken = duration(time.monotonic() - job.start)
            self._view.print(f"{clock()} done  {job.rule}: {job.message}, {taken} {steps}")
            lines = last_lines(job.log) if job.log else []
            if job.rule in self._whole_logs:
                self._view.print("\n".join(lines))
            elif shown := [text for line in lines if (text := parse_marked(line)) is not None]:
                self._view.print("\n".join(shown), CAUTION)
        if not self._done and message["done"] == message["total"]:
            self._view.print(f"{clock()} done  all {message['total']} steps")
        self._done.clear()

    def _fail(self, message: dict[str, Any]) -> None:
        number, rule = message["jobid"], message["rule_name"]
        job = self._run.jobs.pop(number, None)
        title = f" {job.message}" if job else ""
        lines = [f"{clock()} Error in rule {rule}:{title} (job {number})"]
        lines += [f"    {name}: {value}" for name, value in message["aux"].items()]
        for log in message["log"]:
            found = last_lines(Path(log))[-ERROR_LINES:]
            lines.append(f"    the last lines of {log}:" if found else f"    {log} is empty")
            lines += [f"        {line}" for line in found]
        self._view.print("\n".join(lines), FAILURE)

    def _fail_group(self, message: dict[str, Any]) -> None:
        for job in message["job_error_info"]:
            self._run.jobs.pop(job["jobid"], None)

    def _explain(self, message: dict[str, Any]) -> None:
        """Print why a job failed, without its long command line."""
        if message["exception"] == "RuleException":
            self._view.print(COMMAND.sub("The command ", str(message["msg"])), FAILURE)


def _is_kept(record: logging.LogRecord) -> bool:
    """Whether a message reaches the terminal unchanged."""
    event = getattr(record, "event", "")
    explained = event == "error" and getattr(record, "exception", "") == "RuleException"
    return not (event in REPLACED or explained or record.msg == SELECTING)


def _view(run: Run, stream: TextIO) -> "Lines | Bars":
    """Bars on a terminal that can move its cursor, otherwise lines."""
    if not stream.isatty() or os.environ.get("TERM") == "dumb":
        return Lines(run, stream)
    from egad_workflow.display.bars import Bars  # noqa: PLC0415 (it imports rich)

    return Bars(run, stream)
