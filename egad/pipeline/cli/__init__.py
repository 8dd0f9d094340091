"""The `egad` command: one command per stage, and tools."""

import logging
import os
import sys

from egad._util.progress import MARKS, marked
from egad.errors import LESS_MEMORY, RejectedError, TableError, UserError
from egad.pipeline.cli import (
    benchmark,
    exchange,
    grasping,
    gripper,
    measuring,
    origins,
    tools,
    training,
    trials,
)
from egad.pipeline.cli.common import app

__all__ = [
    "benchmark",
    "exchange",
    "grasping",
    "gripper",
    "main",
    "measuring",
    "origins",
    "tools",
    "training",
    "trials",
]


class _Formatter(logging.Formatter):
    """Messages alone; in the logs of the workflow, which shows them, the important are marked."""

    def format(self, record: logging.LogRecord) -> str:
        text = super().format(record)
        shown = record.levelno >= logging.WARNING and MARKS in os.environ
        return marked(text) if shown else text


def main() -> None:
    """Run the command; report errors as one sentence, without a traceback."""
    handler = logging.StreamHandler()
    handler.setFormatter(_Formatter())
    logging.basicConfig(level=logging.WARNING, handlers=[handler])
    logging.getLogger("egad").setLevel(logging.INFO)
    try:
        app()
    except (UserError, TableError, RejectedError) as error:
        sys.exit(f"egad: {error}")
    except MemoryError as error:
        sys.exit(f"egad: out of memory ({error}); {LESS_MEMORY}")
    except OSError as error:
        sys.exit(f"egad: {error.strerror or error}: {error.filename or ''}".rstrip(": "))
