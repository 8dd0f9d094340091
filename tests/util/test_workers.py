import ctypes
import importlib
import os
import signal
import subprocess
import sys
import time
import types
import warnings
from functools import partial
from pathlib import Path

import numpy as np
import psutil
import pytest
from threadpoolctl import threadpool_info

from egad._util.workers import workers
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


def warned(number):
    warnings.warn(f"{number} is odd", UserWarning, stacklevel=1)
    return number


@pytest.mark.parametrize("count", [1, 2])
def test_warnings_of_workers_are_given_in_this_process(count):
    with warnings.catch_warnings(record=True) as found, workers(count) as mapper:
        warnings.simplefilter("always")
        assert list(mapper(warned, [1, 3, 5])) == [1, 3, 5]
    assert [str(each.message) for each in found] == ["1 is odd", "3 is odd", "5 is odd"]
    assert all(each.filename == __file__ for each in found)


def killed(number):
    """What the kernel does when memory runs out."""
    if number == 5:
        os.kill(os.getpid(), signal.SIGKILL)


WANT = r"probably out of memory; use fewer processes: `jobs` in Python.* \(its item: 5\)$"


def test_a_worker_killed_for_memory_stops_all_with_advice():
    with pytest.raises(UserError, match=WANT), workers(2) as mapper:
        list(mapper(killed, range(9)))


def crashed(mesh):
    if mesh["name"] == "B1":
        os.abort()


def test_a_crash_is_told_with_its_item():
    items = [{"name": name, "vertices": np.zeros((900, 3))} for name in ("A0", "B1", "C2")]
    with pytest.raises(UserError) as found, workers(2) as mapper:
        list(mapper(crashed, items))
    message = str(found.value)
    assert message.startswith("a worker process ended with status -6 (its item: {'name': 'B1', ")
    assert len(message) < 200


def failed(number):
    if number == 0:
        raise ZeroDivisionError("no such number")
    time.sleep(600)


def test_an_error_ends_what_else_runs_and_has_the_traceback_of_its_process():
    start = time.monotonic()
    with pytest.raises(ZeroDivisionError, match="no such") as found, workers(2) as mapper:
        list(mapper(failed, range(9)))
    assert time.monotonic() - start < 100
    assert "test_workers.py" in str(found.value.__cause__)
    assert ", in failed" in str(found.value.__cause__)


PROGRAM = """
from egad._util.workers import workers

print("once")

def double(number):
    return scale * number

class Item:
    def __init__(self, number):
        self.number = number

    def __eq__(self, other):
        return type(other) is Item and self.number == other.number

def copy(item):
    return Item(item.number)

scale = 2
with workers(2) as mapper:
    print(list(mapper(double, [1, 2])), list(mapper(lambda number: -number, [1])))
    assert list(mapper(copy, [Item(1), Item(2)])) == [Item(1), Item(2)]
"""
LINES = PROGRAM.strip().splitlines()
GUARDED = "\n".join([LINES[0], 'if __name__ == "__main__":', *(f"  {each}" for each in LINES[1:])])


@pytest.mark.parametrize("program", [PROGRAM, GUARDED])
@pytest.mark.parametrize("given", ["as a file", "in the command", "as input"])
def test_programs_need_no_guard_and_no_file_for_what_they_define(tmp_path, program, given):
    """As in a script of a beginner, or in a notebook."""
    (tmp_path / "program.py").write_text(program)
    options = {"as a file": ["program.py"], "in the command": ["-c", program], "as input": ["-"]}
    done = subprocess.run(
        [sys.executable, *options[given]],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
        input=program,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "once\n[2, 4] [-1]\n"
    assert done.stderr == ""


def test_work_that_cannot_be_sent_is_told(monkeypatch):
    pointer, module = ctypes.pointer(ctypes.c_int(1)), types.ModuleType("only_here")
    exec("def double(number): return 2 * number", module.__dict__)  # noqa: S102 (as a plugin is)
    monkeypatch.setitem(sys.modules, "only_here", module)
    for work, items, why in (
        (partial(max, pointer), [1], "pointers"),
        (abs, [pointer], "pointers"),
        (module.double, [1], "only_here"),
    ):
        want = f"cannot be sent to another process, as several jobs need: .*{why}"
        with pytest.raises(UserError, match=want), workers(2) as mapper:
            list(mapper(work, items))


FRAGILE = """
import os

if "BREAK" in os.environ:
    raise ZeroDivisionError("it breaks")

def double(number):
    return 2 * number
"""


def test_a_module_that_breaks_in_a_process_is_no_crash(tmp_path, monkeypatch):
    (tmp_path / "fragile.py").write_text(FRAGILE)
    monkeypatch.syspath_prepend(tmp_path)
    work = importlib.import_module("fragile").double
    monkeypatch.setenv("BREAK", "yes")
    with pytest.raises(ZeroDivisionError, match="it breaks"), workers(2) as mapper:
        list(mapper(work, [1]))


@pytest.mark.parametrize("count", [0, -1, 1.5, "2", True])
def test_a_number_of_processes_that_is_none_is_told(count):
    with pytest.raises(UserError, match=f"jobs is {count!r}"), workers(count):
        pass


ABANDONS = """
import os, signal, time
from egad._util.workers import workers

def pid(_):
    time.sleep(0.3)
    return os.getpid()

with workers(2) as mapper:
    print(*set(mapper(pid, range(8))), flush=True)
    if BUSY:
        mapper(time.sleep, [600, 600])
        time.sleep(1)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.parametrize("busy", [False, True])
def test_workers_end_when_what_they_work_for_is_killed(tmp_path, busy):
    program = tmp_path / "abandons.py"
    program.write_text(ABANDONS.replace("BUSY", str(busy)))
    with subprocess.Popen([sys.executable, program], stdout=subprocess.PIPE) as process:
        pids = list(map(int, process.stdout.readline().split()))
    assert process.returncode == -signal.SIGKILL
    assert pids
    left = [psutil.Process(pid) for pid in pids if psutil.pid_exists(pid)]
    assert not psutil.wait_procs(left, timeout=60)[1]
