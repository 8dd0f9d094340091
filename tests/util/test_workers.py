import ctypes
import os
import signal
import subprocess
import sys
import warnings
from functools import partial

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


WANT = "probably out of memory; use fewer processes: `jobs` in Python"


def test_a_worker_killed_for_memory_stops_all_with_advice():
    with pytest.raises(UserError, match=WANT), workers(2) as mapper:
        list(mapper(killed, range(9)))


UNGUARDED = """
from egad._util.workers import workers

with workers(2) as mapper:
    print(list(mapper(abs, [-1, -2, -3])))
"""


def test_a_script_without_a_guard_is_told_so_in_one_sentence(tmp_path):
    program = tmp_path / "unguarded.py"
    program.write_text(UNGUARDED)
    done = subprocess.run(
        [sys.executable, program], capture_output=True, text=True, check=False, timeout=300
    )
    *_, last = done.stderr.strip().splitlines()
    assert last.startswith("egad.errors.UserError: a worker process could not start: ")
    assert '`if __name__ == "__main__":`' in last
    assert "bootstrapping phase" not in done.stderr
    assert done.stdout == ""
    guard = "if __name__ == '__main__':\n  with workers"
    program.write_text(UNGUARDED.replace("with workers", guard))
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, check=True)
    assert done.stdout == "[1, 2, 3]\n"


AT_A_PROMPT = """
from egad._util.workers import workers

def double(number):
    return 2 * number

with workers(2) as mapper:
    print(list(mapper(double, [1, 2])))
"""


@pytest.mark.parametrize("program", ["-", "-c"])
def test_functions_of_a_prompt_are_told(program):
    """Given as input or in the command, they have no file that a process could import."""
    command = [sys.executable, program, *([AT_A_PROMPT] if program == "-c" else [])]
    done = subprocess.run(command, input=AT_A_PROMPT, capture_output=True, text=True, check=False)
    assert "must be in a module that can be imported; one of a notebook" in done.stderr
    assert "memory" not in done.stderr


def run(program, **options):
    return subprocess.run(program, capture_output=True, text=True, check=False, **options)


GUARDED = """
from egad._util.workers import workers

if __name__ == "__main__":
    def double(number):
        return 2 * number

    class Item:
        pass

    with workers(2) as mapper:
        print(list(mapper(WORK, ITEMS)))
"""


@pytest.mark.parametrize(("work", "items"), [("double", "[1, 2]"), ("type", "[Item()]")])
def test_what_is_defined_within_the_guard_cannot_be_imported(tmp_path, work, items):
    """Other processes import the script without running what is within the guard."""
    program = tmp_path / "guarded.py"
    program.write_text(GUARDED.replace("WORK", work).replace("ITEMS", items))
    *_, last = run([sys.executable, program]).stderr.strip().splitlines()
    assert "egad.errors.UserError: with several jobs, functions must be in a module" in last
    assert ("double" if work == "double" else "Item") in last
    assert "memory" not in last


def test_a_program_from_standard_input_is_told_that_jobs_need_a_file():
    program = GUARDED.replace("WORK", "abs").replace("ITEMS", "[-1, -2]")
    *_, last = run([sys.executable, "-"], input=program).stderr.strip().splitlines()
    assert "several jobs need a script that is a file" in last
    assert "__main__" not in last


def test_work_that_cannot_be_pickled_is_told():
    pointer = ctypes.pointer(ctypes.c_int(1))
    for work, items in ((partial(max, pointer), [1]), (abs, [pointer]), (lambda _: 1, [1])):
        with pytest.raises(UserError, match="that can be imported"), workers(2) as mapper:
            list(mapper(work, items))


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
