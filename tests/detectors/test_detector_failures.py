"""The first failure of a detector is shown, and one that only fails ends the run."""

import copy
import logging
from functools import partial
from pathlib import Path

import pandas as pd
import pytest

from egad.detectors.base import DetectorTimeoutError
from egad.detectors.failures import (
    FIRST,
    Failure,
    FailureMonitor,
    OnlyFailuresError,
    failure_text,
    keep_failure,
    try_to_plan,
)
from egad.detectors.registry import with_checked_answers
from egad.errors import UserError
from egad.tables.outcomes import Outcome


def divides(_view, _gripper, _rng):
    return 1 / 0


def attempts(*outcomes):
    failed = [each in ("error", "timeout") for each in outcomes]
    texts = [f"went wrong: {each}" * no for each, no in zip(outcomes, failed, strict=True)]
    return pd.DataFrame({"outcome": list(outcomes), "failure": texts})


def test_a_failure_has_the_traceback_of_the_code_of_the_user_alone():
    found = try_to_plan(partial(with_checked_answers(divides), None, None, None))
    assert isinstance(found, Failure)
    assert found.outcome == Outcome.ERROR
    first, *_, last = found.text.splitlines()
    assert first == "Traceback (most recent call last):"
    assert last == "ZeroDivisionError: division by zero"
    line = divides.__code__.co_firstlineno + 1
    assert f'File "test_detector_failures.py", line {line}, in divides' in found.text
    assert str(Path(__file__).parent) not in found.text
    assert "egad/detectors/registry.py" not in found.text


def test_a_long_traceback_keeps_its_innermost_frames():
    def down(depth):
        return 1 / 0 if depth == 0 else down(depth - 1)

    with pytest.raises(ZeroDivisionError) as raised:
        down(200)
    text = failure_text(raised.value)
    assert len(text.splitlines()) < 100
    assert text.endswith("ZeroDivisionError: division by zero")


def test_a_timeout_is_a_failure_and_a_mistake_of_the_user_is_none():
    def slow():
        raise DetectorTimeoutError("1 s")

    def wrong():
        raise UserError("no such file")

    assert try_to_plan(slow) == Failure(Outcome.TIMEOUT, "1 s")
    with pytest.raises(UserError, match="no such file"):
        try_to_plan(wrong)
    assert try_to_plan(lambda: 3) == 3


def test_the_first_failure_is_told_once(caplog):
    monitor = FailureMonitor(9, keep_going=False)
    for table in (attempts("success"), attempts("missed", "timeout"), attempts("error")):
        monitor.check(table)
    (record,) = caplog.records
    assert record.levelno == logging.ERROR
    assert "went wrong: timeout" in record.getMessage()


@pytest.mark.parametrize("outcome", ["error", "timeout"])
def test_a_detector_that_only_fails_ends_the_run_at_the_third_object(caplog, outcome):
    monitor = FailureMonitor(49, keep_going=False)
    for _ in range(FIRST - 1):
        monitor.check(attempts(outcome, outcome))
    monitor.check(attempts("failed", "crashed"))  # it was not even asked
    with pytest.raises(
        UserError, match=f"all {2 * FIRST} attempts of the first {FIRST} objects"
    ) as raised:
        monitor.check(attempts(outcome, outcome))
    told = caplog.text + str(raised.value)
    assert told.count(f"went wrong: {outcome}") == 1
    assert "--" not in str(raised.value)  # no option of a command


def test_it_ends_with_the_last_object_if_there_are_fewer():
    monitor = FailureMonitor(1, keep_going=False)
    with pytest.raises(UserError, match="all 2 attempts of the first object;"):
        monitor.check(attempts("error", "error"))


def test_a_quiet_monitor_tells_the_failure_as_it_ends_the_run():
    monitor = FailureMonitor(1, keep_going=False, quiet=True)
    with pytest.raises(UserError, match=r"first failure:\nwent wrong: error"):
        monitor.check(attempts("error"))


def test_the_failure_that_ends_a_run_is_kept_beside_its_output(tmp_path):
    kept = tmp_path / "out.parquet.failure.txt"
    with (
        pytest.raises(UserError, match="was written to"),
        keep_failure(tmp_path / "out.parquet"),
    ):
        raise copy.copy(OnlyFailuresError("only failures", "went wrong"))  # as by pickle
    assert kept.read_text(encoding="utf-8") == "went wrong\n"
    with keep_failure(tmp_path / "out.parquet"):
        pass  # a later run
    assert not kept.exists()


def test_it_goes_on_if_wanted_or_if_anything_else_ever_happened():
    wanted = FailureMonitor(5, keep_going=True)
    once = FailureMonitor(5, keep_going=False)
    once.check(attempts("error", "no_grasp"))
    for monitor, count in ((wanted, 5), (once, 4)):
        for _ in range(count):
            monitor.check(attempts("error"))


def test_objects_that_cannot_be_simulated_end_nothing():
    monitor = FailureMonitor(2, keep_going=False)
    monitor.check(attempts("failed"))
    monitor.check(attempts("failed"))
