"""Commands of `egad` within the process of the tests: as a process of their own, but quick."""

import logging
import os
import sys
import tempfile
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from unittest.mock import patch

from egad.cli import main


@dataclass(frozen=True)
class Finished:
    """What a command printed, and its exit status."""

    returncode: int
    stdout: str
    stderr: str


def egad(*arguments):
    """Run a command to its end."""
    stdout = StringIO()
    with (
        patch.object(sys, "argv", ["egad", *map(str, arguments)]),
        redirect_stdout(stdout),
        _own_stderr() as stderr,
        _own_logging(),
    ):
        status = _status()
        stderr.seek(0)
        return Finished(status, stdout.getvalue(), stderr.read())


def _status():
    """The exit status of `main`, which says on stderr what Python would say there."""
    try:
        main()
    except SystemExit as end:
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
            return 1
        return end.code or 0
    return 0


@contextmanager
def _own_stderr():
    """The file that this process and those that it starts write errors to meanwhile."""
    kept = os.dup(2)
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace", buffering=1) as file:
        os.dup2(file.fileno(), 2)
        try:
            with redirect_stderr(file):
                yield file
        finally:
            os.dup2(kept, 2)
            os.close(kept)


@contextmanager
def _own_logging():
    """No handlers, as in a new process; those of pytest again afterwards."""
    root, own = logging.getLogger(), logging.getLogger("egad")
    kept = root.handlers[:], root.level, own.level
    root.handlers = []
    try:
        yield
    finally:
        root.handlers, level, own_level = kept
        root.setLevel(level)
        own.setLevel(own_level)
