"""The `egad` command: one command per stage, and tools."""

import logging
import sys

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


def main() -> None:
    """Run the command; report errors as one sentence, without a traceback."""
    logging.basicConfig(level=logging.WARNING, format="%(message)s", stream=sys.stderr)
    logging.getLogger("egad").setLevel(logging.INFO)
    try:
        app()
    except (UserError, TableError, RejectedError) as error:
        sys.exit(f"egad: {error}")
    except MemoryError as error:
        sys.exit(f"egad: out of memory ({error}); {LESS_MEMORY}")
    except OSError as error:
        sys.exit(f"egad: {error.strerror or error}: {error.filename or ''}".rstrip(": "))
