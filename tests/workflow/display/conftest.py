"""A run of Snakemake as its messages tell it, and where they are shown."""

import io
import logging
from types import SimpleNamespace

import pytest

from egad_workflow.display import messages


class Terminal(io.StringIO):
    """A stream that may be a terminal."""

    def __init__(self, tty):
        super().__init__()
        self._tty = tty

    def isatty(self):
        return self._tty


class Run:
    """Sends the messages that Snakemake sends while it runs jobs."""

    def __init__(self, folder, tty):
        self.folder, self.stream = folder, Terminal(tty)
        self.logger = logging.Logger("run")
        self.handler = logging.StreamHandler(self.stream)
        self.handler.name = messages.SNAKEMAKE_HANDLER
        self.logger.addHandler(self.handler)

    def send(self, text, event=None, level=logging.INFO, **fields):
        self.logger.log(level, text, extra={"event": event, **fields} if event else None)

    def log(self, number):
        return self.folder / f"{number}.log"

    def start(self, number, rule="evolve", message="Evolving", logged=True):
        fields = {"rule_name": rule, "rule_msg": message, "shellcmd": None}
        log = [str(self.log(number))] if logged else []
        self.send("long", "job_info", jobid=number, log=log, **fields)

    def finish(self, number, done=1):
        self.send("long", "job_finished", job_id=number)
        self.send(None, "progress", done=done, total=5)

    def fail(self, number):
        reason = "CalledProcessError in file \"F\", line 3:\nCommand 'set -e;\n long' "
        reason = f"RuleException:\n{reason}returned non-zero exit status 137."
        self.send(reason, "error", logging.ERROR, exception="RuleException")
        fields = {"rule_name": "evolve", "log": [str(self.log(number))], "aux": {"node": 7}}
        self.send("long", "job_error", logging.ERROR, jobid=number, **fields)

    @property
    def shown(self):
        return self.stream.getvalue()


@pytest.fixture
def start_run(tmp_path, monkeypatch):
    """Starts runs with a display, in a pipe or on a terminal; all are ended at last."""
    runs = []

    def start(tty=False, quiet=(), **options):
        run = Run(tmp_path, tty)
        monkeypatch.setattr(messages, "LOGGER", run.logger)
        asked = SimpleNamespace(filter=lambda _: True, quiet=quiet)
        run.handler.addFilter(asked)
        messages.start_display(5, **options)
        runs.append(run)
        return run

    yield start
    for run in runs:
        for handler in run.logger.handlers:
            handler.close()
