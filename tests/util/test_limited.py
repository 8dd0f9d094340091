import os
import signal
import time

import numpy as np
import pytest

from egad._util.limited import FailedError, LimitedProcess, LimitError
from egad.errors import RejectedError, UserError


@pytest.fixture
def limited():
    process = LimitedProcess(memory=1 << 30, seconds=30)
    yield process
    process.close()


def test_a_result_is_that_of_the_function(limited):
    assert np.array_equal(limited(np.arange, 5), np.arange(5))
    assert limited(os.getpid) == limited(os.getpid) != os.getpid()


def test_too_much_memory_is_named_and_the_next_call_works(limited):
    assert len(limited(np.ones, 10_000_000)) == 10_000_000
    with pytest.raises(LimitError, match=r"more than 1,024 MiB of memory"):
        limited(np.ones, 200_000_000)
    assert limited(np.sum, [1, 2]) == 3


def test_a_call_that_takes_too_long_is_ended():
    limited = LimitedProcess(memory=1 << 30, seconds=2)
    start = time.monotonic()
    with pytest.raises(LimitError, match=r"more than 2 s"):
        limited(time.sleep, 100)
    assert time.monotonic() - start < 50
    assert limited(sum, [1, 2]) == 3
    limited.close()


def test_a_process_that_aborts_ends_nothing_else(limited):
    with pytest.raises(LimitError, match="ended with status -6"):
        limited(os.abort)
    assert limited(np.sum, [1, 2]) == 3


def test_a_process_that_the_system_kills_is_not_to_blame(limited):
    child = limited(os.getpid)
    with pytest.raises(UserError, match="was killed"):
        limited(os.kill, child, signal.SIGKILL)


def test_errors_are_passed_on(limited):
    with pytest.raises(FailedError, match=r"ZeroDivisionError: .*by zero"):
        limited(divmod, 1, 0)
    with pytest.raises(RejectedError, match="a reason"):
        limited(_reject)


def _reject():
    raise RejectedError("a reason")
