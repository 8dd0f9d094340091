import os

import pytest

from egad._util.progress import Status
from egad_workflow.display import jobs as module
from egad_workflow.display.jobs import Job, last_lines, last_progress


@pytest.fixture
def log(tmp_path):
    return tmp_path / "job.log"


def test_a_job_is_starting_until_it_writes_to_its_log(log):
    log.write_text("evaluations: 9/9\n")  # by an earlier run
    job = Job("evolve", "Evolving", log)
    assert job.read() == (None, "starting")
    log.write_text("evaluations: 2/9, 1.00/s, 0:07 left\n")
    os.utime(log, (0, 0))
    assert job.read() == (Status("evaluations", 2, 9, 1.0), "")


def test_a_job_without_a_word_for_long_is_not_starting_any_more(log):
    job = Job("evolve", "Evolving", log, start=-1e6)
    assert job.read() == (None, "no output yet")


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ([], (None, "starting")),
        (["a warning"], (None, "starting")),
        (["compiling kernels ..."], (None, "compiling kernels")),
        (["a: 1/4", "a warning", "a: 2/4"], (Status("a", 2, 4), "")),
        (["reading ...", "a: 1/4", "compiling ...", "!"], (Status("a", 1, 4), "compiling")),
        (["a: 4/4", "writing ..."], (None, "writing")),
        (["a: 4/4", "480 elites"], (Status("a", 4, 4), "")),
    ],
)
def test_the_last_progress_and_what_is_done_since_are_found(lines, expected):
    assert last_progress(lines) == expected


def test_of_a_long_log_only_the_end_is_read(log):
    log.write_bytes(b"\xff\n" + b"x" * 10 * module.READ_BYTES + b"\na: 1/4\n")
    assert last_lines(log)[-1] == "a: 1/4"
    assert sum(map(len, last_lines(log))) <= module.READ_BYTES
