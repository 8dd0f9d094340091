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
import worker_tasks
from worker_tasks import Counted, crashed, failed, finalized, killed, threads_for_algebra, warned

from egad._util.workers import workers
from egad.errors import UserError


@pytest.mark.parametrize("count", [1, 2])
def test_a_worker_has_one_thread_for_algebra(count):
    with workers(count) as mapper:
        found = list(mapper(threads_for_algebra, [np.eye(3)] * 4))
    assert all(found)
    assert all(count == 1 for counts in found for count in counts)


@pytest.mark.parametrize("count", [1, 2])
def test_warnings_of_workers_are_given_in_this_process(count):
    with warnings.catch_warnings(record=True) as found, workers(count) as mapper:
        warnings.simplefilter("always")
        assert list(mapper(warned, [1, 3, 5])) == [1, 3, 5]
    assert [str(each.message) for each in found] == ["1 is odd", "3 is odd", "5 is odd"]
    assert all(each.filename == worker_tasks.__file__ for each in found)


WANT = r"probably out of memory; use fewer processes: `jobs` in Python.* \(its item: 5\)$"


def test_a_worker_killed_for_memory_stops_all_with_advice():
    with pytest.raises(UserError, match=WANT), workers(2) as mapper:
        list(mapper(killed, range(9)))


def test_a_crash_is_told_with_its_item():
    items = [{"name": name, "vertices": np.zeros((900, 3))} for name in ("A0", "B1", "C2")]
    with pytest.raises(UserError) as found, workers(2) as mapper:
        list(mapper(crashed, items))
    message = str(found.value)
    assert message.startswith("a worker process ended with status -6 (its item: {'name': 'B1', ")
    assert len(message) < 200


def test_an_error_ends_what_else_runs_and_has_the_traceback_of_its_process():
    start = time.monotonic()
    with pytest.raises(ZeroDivisionError, match="no such") as found, workers(2) as mapper:
        list(mapper(failed, range(9)))
    assert time.monotonic() - start < 100
    assert "worker_tasks.py" in str(found.value.__cause__)
    assert ", in failed" in str(found.value.__cause__)


def test_processes_end_together_and_by_themselves_when_all_is_done(tmp_path):
    with workers(2) as mapper:
        pids = set(mapper(finalized, [tmp_path] * 2))
    assert {int(path.stem) for path in tmp_path.glob("*.ended")} == pids
    assert len(pids) == 2


def test_work_is_pickled_once_and_unpickled_once_in_each_process(monkeypatch):
    monkeypatch.setattr(Counted, "pickled", 0)
    with workers(2) as mapper:
        counts = set(mapper(Counted(), range(20)))
    assert Counted.pickled == 1
    assert counts == {1}


PROGRAM = """
import egad
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
    assert egad.__name__ == "egad"  # a module with lazy attributes
    return Item(item.number)

scale = 2
with workers(2) as mapper:
    print(list(mapper(double, [1, 2])), list(mapper(lambda number: -number, [1])))
    assert list(mapper(copy, [Item(1), Item(2)])) == [Item(1), Item(2)]
"""
LINES = PROGRAM.strip().splitlines()
GUARDED = "\n".join(
    [*LINES[:2], 'if __name__ == "__main__":', *(f"  {each}" for each in LINES[2:])]
)


def output(arguments, given, folder):
    """What Python prints, which is no error."""
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
        input=given,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr == ""
    return done.stdout


@pytest.mark.parametrize(
    ("given", "program"),
    [
        ("as a file", PROGRAM),
        ("as a file", GUARDED),
        ("in the command", PROGRAM),
        ("as input", PROGRAM),
    ],
)
def test_programs_need_no_guard_and_no_file_for_what_they_define(tmp_path, given, program):
    """As in a script of a beginner, or in a notebook."""
    (tmp_path / "program.py").write_text(program)
    options = {"as a file": ["program.py"], "in the command": ["-c", program], "as input": ["-"]}
    assert output(options[given], program, tmp_path) == "once\n[2, 4] [-1]\n"


CACHES = """
import functools
import os
import threading

from egad._util.workers import workers
from egad.errors import UserError

loads = []

@functools.cache
def model():
    loads.append("from a file")
    return 10

@functools.lru_cache(maxsize=50, typed=True)
def fibonacci(number):
    return number if number < 2 else fibonacci(number - 1) + fibonacci(number - 2)

class Item:
    @functools.cache
    def double(self):
        return 2 * model()

fibonacci.author = "Leonardo"
length = functools.cache(len)
imported = functools.cache(functools.cmp_to_key)

def work(number):
    assert Item().double() == 20
    assert (fibonacci.author, fibonacci.__name__) == ("Leonardo", "fibonacci")
    assert fibonacci.cache_parameters() == {"maxsize": 50, "typed": True}
    assert imported.cache_parameters() == {"maxsize": None, "typed": False}
    return model() + length("abc") + fibonacci(number), len(loads)

lock = threading.Lock()

def locked(number):
    with lock:
        return number

with workers(2) as mapper:
    print(*mapper(work, [30, 31, 32, 33]), loads)
    print(*mapper(functools.cache(lambda number: -number), [1, 2]))
    try:
        mapper(locked, [1])
    except UserError as error:
        print(error)
"""
PRINTED = """\
(832053, 1) (1346282, 1) (2178322, 1) (3524591, 1) []
-1 -2
this cannot be sent to another process, which more than one job requires; put it into a module \
of its own, or use 1 job: cannot pickle '_thread.lock' object
"""


def test_cached_functions_of_programs_are_sent_and_locks_are_told(tmp_path):
    assert output(["-c", CACHES], "", tmp_path) == PRINTED


def test_work_that_cannot_be_sent_is_told(monkeypatch):
    pointer, module = ctypes.pointer(ctypes.c_int(1)), types.ModuleType("only_here")
    exec("def double(number): return 2 * number", module.__dict__)  # noqa: S102 (as a plugin is)
    monkeypatch.setitem(sys.modules, "only_here", module)
    for work, items, why in (
        (partial(max, pointer), [1], "pointers"),
        (abs, [pointer], "pointers"),
        (module.double, [1], "only_here"),
    ):
        want = (
            "cannot be sent to another process, which more than one job requires; .*, or use 1 "
            f"job: .*{why}"
        )
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
import builtins, ctypes, os, signal, sys, time
from egad._util.child_process import Worker
from egad._util.workers import workers

BUSY = sys.argv[1]

def pids(number):
    time.sleep(0.3)
    if not BUSY:
        return (os.getpid(),)
    if not hasattr(builtins, "reader"):
        builtins.reader = Worker(HoldsTheLock)
    return os.getpid(), builtins.reader(0)

class HoldsTheLock:
    def __enter__(self):
        return lambda number: ctypes.PyDLL(None).sleep(600) if number else os.getpid()

    def __exit__(self, *_):
        pass

def wait(number):
    if BUSY:
        builtins.reader(600)

with workers(2) as mapper:
    print(*{pid for some in mapper(pids, range(8)) for pid in some}, flush=True)
    mapper(wait, [600, 600])
    time.sleep(1)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.parametrize("busy", ["", "busy"])
def test_workers_and_theirs_end_when_what_they_work_for_is_killed(tmp_path, busy):
    """Also those in compiled code that lets no other thread of Python run."""
    program = tmp_path / "abandons.py"
    program.write_text(ABANDONS)
    with subprocess.Popen([sys.executable, program, busy], stdout=subprocess.PIPE) as process:
        pids = list(map(int, process.stdout.readline().split()))
    assert process.returncode == -signal.SIGKILL
    assert len(pids) == (4 if busy else 2)
    left = [psutil.Process(pid) for pid in pids if psutil.pid_exists(pid)]
    assert not psutil.wait_procs(left, timeout=5)[1]
