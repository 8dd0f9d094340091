import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from functools import partial

import numpy as np
import psutil
import pytest
from threadpoolctl import threadpool_info

from egad._util.workers import Survivor, workers
from egad.errors import UserError


def threads_for_algebra(matrix):
    assert np.linalg.det(matrix) == 1
    return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]


def test_results_are_in_order():
    with workers(2) as mapper:
        assert list(mapper(abs, range(-9, 0))) == list(range(9, 0, -1))


@pytest.mark.parametrize("count", [1, 2])
def test_a_worker_has_one_thread_for_algebra(count):
    with workers(count) as mapper:
        found = list(mapper(threads_for_algebra, [np.eye(3)] * 4))
    assert all(found)
    assert all(count == 1 for counts in found for count in counts)


def killed(number):
    """What the kernel does when memory runs out."""
    if number == 5:
        os.kill(os.getpid(), signal.SIGKILL)


WANT = "probably for want of memory; use fewer cores: --jobs"


def test_a_worker_killed_for_memory_stops_all_with_advice():
    with pytest.raises(UserError, match=WANT), workers(2) as mapper:
        list(mapper(killed, range(9)))


ABANDONS = """
import os, signal, time
from egad._util.workers import workers

def pid(_):
    time.sleep(0.3)
    return os.getpid()

if __name__ == "__main__":
    with workers(2) as mapper:
        print(*set(mapper(pid, range(8))), flush=True)
        os.kill(os.getpid(), signal.SIGKILL)
"""


def test_workers_end_when_what_they_work_for_is_killed(tmp_path):
    program = tmp_path / "abandons.py"
    program.write_text(ABANDONS)
    with subprocess.Popen([sys.executable, program], stdout=subprocess.PIPE) as process:
        pids = list(map(int, process.stdout.readline().split()))
    assert process.returncode == -signal.SIGKILL
    assert pids
    left = [psutil.Process(pid) for pid in pids if psutil.pid_exists(pid)]
    assert not psutil.wait_procs(left, timeout=60)[1]


@contextmanager
def halving(marks):
    """Halves numbers; 0 ends the process the first time, 13 always, and text is an error."""

    def half(number):
        killed(number)
        if number == 13 or (number == 0 and not marks.exists()):
            marks.touch()
            os.abort()
        return number / 2

    marks.with_suffix(".open").touch()
    yield half
    marks.with_suffix(".closed").touch()


@contextmanager
def refusing():
    raise UserError("this cannot be made")
    yield


@contextmanager
def dying():
    os.abort()
    yield


def test_a_process_that_dies_is_started_anew_and_dying_twice_gives_none(tmp_path):
    marks = tmp_path / "died"
    with Survivor(partial(halving, marks)) as work:
        assert [work(number) for number in (4, 0, 2, 13, 6)] == [2, 0, 1, None, 3]
    assert marks.with_suffix(".closed").exists()


def test_being_killed_for_memory_is_no_result_of_the_work(tmp_path):
    with pytest.raises(UserError, match=WANT), Survivor(partial(halving, tmp_path / "a")) as work:
        work(5)


def test_errors_of_the_work_are_raised_and_the_next_item_goes_on(tmp_path):
    with Survivor(partial(halving, tmp_path / "died")) as work:
        with pytest.raises(TypeError):
            work("text")
        assert work(4) == 2


def test_what_cannot_be_made_in_the_process_is_said():
    with pytest.raises(UserError, match="this cannot be made"), Survivor(refusing):
        pass
    with pytest.raises(UserError, match="while it started"), Survivor(dying):
        pass


class PathError(UserError):
    """One that is pickled, but cannot be unpickled: it is made from something else."""

    def __init__(self, path, reason):
        super().__init__(f"{path}: {reason}")


class LocalError(Exception):
    """One that cannot be pickled."""

    def __reduce__(self):
        raise TypeError("not this one")


@contextmanager
def raising():
    def work(item):
        if item == "user":
            raise PathError("a.h5", "damaged")
        if item == "local":
            raise LocalError("what went wrong")
        return (lambda: 0) if item == "result" else os.getpid()

    yield work


@contextmanager
def not_starting():
    raise LocalError("no such engine")
    yield


def test_what_cannot_be_pickled_is_told_as_text_and_is_no_crash():
    with Survivor(raising) as work:
        process = work("ask")
        with pytest.raises(UserError, match=r"^a\.h5: damaged$"):
            work("user")
        with pytest.raises(RuntimeError, match=r"^LocalError: what went wrong$"):
            work("local")
        with pytest.raises((AttributeError, TypeError), match="pickle"):
            work("result")
        assert work("ask") == process
    with pytest.raises(RuntimeError, match="no such engine"), Survivor(not_starting):
        pass


@contextmanager
def sleeping(marks):
    """Naps; 0 oversleeps the first time, 13 always."""

    def nap(number):
        if number == 13 or (number == 0 and not marks.exists()):
            marks.touch()
            time.sleep(600)
        return number / 2

    yield nap
    if marks.with_suffix(".last").exists():
        time.sleep(600)


def test_a_process_that_takes_too_long_is_ended_and_counts_as_one_that_died(tmp_path, caplog):
    marks = tmp_path / "overslept"
    before = time.monotonic()
    with Survivor(partial(sleeping, marks), limit=0.5) as work:
        assert [work(number) for number in (4, 0, 13, 6)] == [2, 0, None, 3]
        marks.with_suffix(".last").touch()
    assert time.monotonic() - before < 200
    assert caplog.text.count("ended after 0.5 seconds") == 3
