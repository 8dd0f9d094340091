import logging

import pytest

from egad._util.progress import MARKS
from egad.errors import LESS_MEMORY, RejectedError, TableError, UserError
from egad_workflow.program import _Formatter, readable_errors


@pytest.mark.parametrize("marks", [False, True])
def test_warnings_are_marked_in_the_workflow_alone(monkeypatch, marks):
    if marks:
        monkeypatch.setenv(MARKS, "1")
    message = logging.LogRecord("egad", logging.WARNING, "", 0, "mind this", None, None)
    assert _Formatter().format(message) == "! " * marks + "mind this"


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (UserError("not allowed"), "egad: not allowed"),
        (TableError("damaged"), "egad: damaged"),
        (RejectedError("no faces"), "egad: no faces"),
        (MemoryError("8 GB"), f"egad: out of memory (8 GB); {LESS_MEMORY}"),
        (FileNotFoundError(2, "No such file", "a.obj"), "egad: No such file: a.obj"),
        (OSError("disk full"), "egad: disk full"),
    ],
)
def test_what_a_user_can_mend_ends_the_program_with_a_sentence(error, sentence):
    with pytest.raises(SystemExit) as ended, readable_errors():
        raise error
    assert ended.value.code == sentence


def test_other_errors_keep_their_traceback():
    with pytest.raises(ZeroDivisionError), readable_errors():
        raise ZeroDivisionError
