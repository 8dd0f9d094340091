"""Failures of a detector: the error with its traceback, and when failures end a run."""

import logging
import math
import re
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import pandas as pd

from egad.detectors.base import DetectorError, DetectorTimeoutError
from egad.errors import UserError
from egad.tables.outcomes import SIMULATION_FAILURES, Outcome

log = logging.getLogger(__name__)
T = TypeVar("T")

PACKAGE = Path(__file__).parents[1]
FOLDER_OF_FRAME = re.compile(r'^(\s*File ")[^"]*[/\\]', re.MULTILINE)
FRAMES = 20  # of a traceback, the innermost ones
FIRST = 3  # objects, or rounds, at which a detector that only fails ends the run
FAILURES = (Outcome.ERROR, Outcome.TIMEOUT)


@dataclass(frozen=True)
class Failure:
    """A detector failed in an attempt: with an error or by timeout; the text has the traceback."""

    outcome: Outcome
    text: str


class OnlyFailuresError(UserError):
    """A detector does nothing but fail; `failure` is the text of the first failure."""

    def __init__(self, text: str, failure: str = "") -> None:
        super().__init__(text)
        self.failure = failure


@contextmanager
def keep_failure(out: Path) -> Iterator[None]:
    """Write the failure that ends a run into `OUT.failure.txt`, which its UserError names."""
    path = out.with_name(f"{out.name}.failure.txt")
    path.unlink(missing_ok=True)
    try:
        yield
    except OnlyFailuresError as error:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"{error.failure}\n", encoding="utf-8")
        raise UserError(f"{error}\nThe first failure was written to {path}") from error


def try_to_plan(plan: Callable[[], T]) -> T | Failure:
    """The result of asking a detector, or how it failed, unless it cannot be used at all."""
    try:
        return plan()
    except (UserError, MemoryError):
        raise
    except DetectorTimeoutError as error:
        return Failure(Outcome.TIMEOUT, str(error))
    except Exception as error:
        return Failure(Outcome.ERROR, failure_text(error))


def failure_text(error: Exception) -> str:
    """An error with its traceback from outside of egad on, files without their folders."""
    if isinstance(error, DetectorError):
        return str(error)
    trace = error.__traceback__
    while trace and Path(trace.tb_frame.f_code.co_filename).is_relative_to(PACKAGE):
        trace = trace.tb_next
    shown = trace or error.__traceback__
    lines = traceback.format_exception(type(error), error, shown, limit=-FRAMES)
    return FOLDER_OF_FRAME.sub(r"\1", "".join(lines)).rstrip()


class FailureMonitor:
    """Logs the first failure of a detector, and ends a run in which it does nothing but fail."""

    def __init__(
        self,
        total: int | None,
        keep_going: bool,
        what: str = "objects",
        *,
        quiet: bool = False,
        remedy: str = "; to continue anyway, set keep_going",
    ) -> None:
        """Begin a run of `total` objects or rounds (`what`); `remedy` ends the last message."""
        self._remedy = remedy
        self._left = math.inf if total is None else total
        self._keep_going, self._what, self._quiet = keep_going, what, quiet
        self._objects = self._attempts = 0  # at which the detector did nothing but fail
        self._worked = False
        self._first = ""

    def check(self, table: pd.DataFrame) -> None:
        """Look at the next attempts; OnlyFailuresError if the first three, or all, have failed."""
        texts = table.loc[table["failure"].fillna("") != "", "failure"]
        if not self._first and len(texts):
            self._first = str(texts.iloc[0])
            if not self._quiet:
                log.error("first failure of the detector:\n%s", self._first)
        self._left -= 1
        asked = table[~table["outcome"].isin(SIMULATION_FAILURES)]
        if len(asked):
            self._worked |= not asked["outcome"].isin(FAILURES).all()
            self._objects, self._attempts = self._objects + 1, self._attempts + len(asked)
        if self._is_hopeless():
            told = f". Its first failure:\n{self._first}" if self._quiet else ""
            raise OnlyFailuresError(
                f"the detector failed in all {self._attempts} attempts of {self._asked()}"
                f"{self._remedy}{told}",
                self._first,
            )

    def _asked(self) -> str:
        """The objects or rounds at which it did nothing but fail."""
        one = self._objects == 1
        return f"the first {self._what[:-1]}" if one else f"the first {self._objects} {self._what}"

    def _is_hopeless(self) -> bool:
        enough = self._objects >= FIRST or (self._left == 0 and self._objects > 0)
        return enough and not self._worked and not self._keep_going
