"""The workflow on a real Slurm cluster of one node: `make slurm`."""

import os
import subprocess

import pytest
import slurm_node

pytestmark = [
    pytest.mark.slurm,
    pytest.mark.skipif(bool(slurm_node.why_not()), reason=slurm_node.why_not()),
    pytest.mark.timeout(1800),
]
PROFILE = ["--profile", "profiles/slurm", "--max-threads", os.cpu_count()]
# There is no database of accounts and past jobs, and files are seen at once.
HERE = [
    *["--slurm-no-account", "--slurm-status-command", "squeue"],
    *["--slurm-init-seconds-before-status-checks", 2, "--seconds-between-status-checks", 2],
    *["--latency-wait", 5],
]


@pytest.fixture(scope="module", autouse=True)
def _slurm(tmp_path_factory):
    with slurm_node.cluster(tmp_path_factory.mktemp("slurm")):
        yield


def queued(columns):
    """What was asked for all jobs so far, the first first."""
    command = ["squeue", "--states", "all", "--noheader", "--sort", "i", "--format", columns]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [line.split() for line in said.splitlines()]


def test_slurm_makes_the_same_bytes(clean, finished):
    clean.make(*PROFILE, *HERE)
    assert clean.bytes() == finished.bytes()
    jobs = queued("%T %m %k")
    assert len(jobs) > 10
    # in the first attempt, within what was asked for
    assert [job for job in jobs if job[0] != "COMPLETED"] == []


def test_a_job_that_was_killed_for_memory_gets_more(clean):
    hold = "python -c 'import time; held = bytearray(1500 << 20); time.sleep(4)'"
    before = len(queued("%i"))
    clean.feed(*PROFILE, *HERE, needs=(600, 2), command=f"{hold} && touch {{output}}")
    assert queued("%T %m %l")[before:] == [
        ["FAILED", "1300M", "2:00"],
        ["COMPLETED", "2600M", "4:00"],
    ]
