"""Common to all programs of egad: messages on stderr, and user errors as one sentence."""

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from egad._util.extras import needed_for
from egad._util.memory import check_memory, is_out_of_memory, out_of_memory
from egad._util.progress import MARKS, marked
from egad.errors import LESS_MEMORY, RejectedError, TableError, UserError


class _Formatter(logging.Formatter):
    """Messages alone; in logs of the workflow, important ones are marked so that it shows them."""

    def format(self, record: logging.LogRecord) -> str:
        text = super().format(record)
        shown = record.levelno >= logging.WARNING and MARKS in os.environ
        return marked(text) if shown else text


def start_logging() -> None:
    """Show messages of egad, and warnings of other packages, on stderr."""
    handler = logging.StreamHandler()
    handler.setFormatter(_Formatter())
    logging.basicConfig(level=logging.WARNING, handlers=[handler])
    logging.getLogger("egad").setLevel(logging.INFO)


@contextmanager
def readable_errors() -> Iterator[None]:
    """End the program with one sentence and no traceback for errors that the user can fix."""
    try:
        check_memory()
        with needed_for("this"):
            yield
    except (UserError, TableError, RejectedError) as error:
        sys.exit(f"egad: {error}")
    except Exception as error:
        if is_out_of_memory(error):
            sys.exit(f"egad: {out_of_memory(error)}; {LESS_MEMORY}")
        if not isinstance(error, OSError):
            raise
        sys.exit(f"egad: {error.strerror or error}: {error.filename or ''}".rstrip(": "))
