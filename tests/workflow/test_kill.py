"""Runs that are killed with all their processes go on to the same bytes."""

import os
import signal
import subprocess
import time
from collections import Counter

import numpy as np
import psutil
import pytest
from running_scripts import script_of

KILLS, SEED = 20, 8


@pytest.mark.slow
@pytest.mark.timeout(4 * 3600)
def test_twenty_kills_at_random_moments_leave_no_trace(finished, another):
    """Where a run comes to its end before all kills are spent, the next one begins."""
    moments, most = np.random.default_rng(SEED), files(finished) // 4
    expected, killed, runs = finished.bytes(), [], 1
    run = another("run-1")
    while len(killed) < KILLS:
        more, delay = moments.integers(0, most), moments.uniform(0, 1)
        at_work = killed_after(more, delay, run)
        if at_work is None:
            assert run.bytes() == expected
            runs += 1
            run = another(f"run-{runs}")
        else:
            killed.append(at_work)
            print(
                f"kill {len(killed)}, after {more} files and {delay:.1f} s: {at_work}", flush=True
            )
            run.make("--unlock")
    run.make("--cores", 2)
    assert run.bytes() == expected
    hit = Counter(script for at_work in killed for script in at_work)
    print(f"{KILLS} kills in {runs} runs: {dict(hit)}")
    assert len(hit) >= 6


def files(run):
    """How many files the results of a run have."""
    return sum(len(names) for *_, names in os.walk(run.results))  # passes over vanished folders


def killed_after(more, delay, run):
    """Kill a run some seconds after it has made more files: the stages that were at work.

    None if it ended before. All of it stands still while it is looked at, so what is named is what
    was killed.
    """
    wanted, process = files(run) + more, run.start("--cores", 2)
    while process.poll() is None and files(run) < wanted:
        time.sleep(0.1)
    try:
        said, _ = process.communicate(timeout=delay)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGSTOP)
        tree = psutil.Process(process.pid).children(recursive=True)
        at_work = sorted({script for child in tree if (script := script_of(child))})
        os.killpg(process.pid, signal.SIGKILL)
        said, _ = process.communicate()
        assert not psutil.wait_procs(tree, timeout=60)[1]
        if process.returncode == -signal.SIGKILL:
            return at_work
    assert process.returncode == 0, said
    return None
