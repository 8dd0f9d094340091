import itertools
import time

import pytest

from egad._util.progress import Pace
from egad_workflow.display import lines as module
from egad_workflow.display.jobs import Job, Run
from egad_workflow.display.lines import Lines, job_line


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(module, "TICK", 0.01)
    monkeypatch.setattr(module, "PEOPLE", Pace(0.05, 0.2, 1.0))


def wait_for(condition):
    end = time.monotonic() + 10
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.usefixtures("quick")
def test_a_job_that_has_ended_is_not_told_of_any_more(start_run):
    run = start_run()
    run.start(1)
    wait_for(lambda: "so far" in run.shown)
    run.finish(1)
    before = run.shown
    time.sleep(0.5)
    assert run.shown == before


def test_a_short_job_has_no_line_and_a_long_one_fewer_and_fewer():
    run = Run((0, 1), {1: Job("evolve", "Evolving", None, start=0.0)})
    view = Lines(run, None)
    view.close()
    told = [now / 2 for now in range(2 * 3600) if list(view._lines(now / 2))]
    assert told[:5] == [15, 30, 60, 120, 180]
    assert {after - before for before, after in itertools.pairwise(told[3:])} == {60}


def test_a_line_tells_how_far_a_job_is_and_what_it_does(tmp_path):
    job = Job("evolve", "Evolving", tmp_path / "log", start=100.0)
    job.log.write_text("evaluations: 20/100\ncompiling kernels ...\n")
    assert job_line(job, 165.0) == "Evolving: evaluations: 20/100, compiling kernels, 1:05 so far"
