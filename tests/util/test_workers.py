import os
import signal
import subprocess
import sys

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


def killed(number):
    """What the kernel does when memory runs out."""
    if number == 5:
        os.kill(os.getpid(), signal.SIGKILL)


WANT = "probably out of memory; use fewer cores: --jobs"


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
