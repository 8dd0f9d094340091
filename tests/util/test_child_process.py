import sys
import time
import types
from functools import partial

import pytest
from worker_tasks import (
    dying,
    ending_a_file,
    halving,
    not_starting,
    raising,
    refusing,
    sleeping,
    unreadable,
)

from egad._util.child_process import Worker, WorkerDiedError, WorkerTimeoutError
from egad.errors import UserError
from egad_workflow.restarting_worker import RestartingWorker

MODULE = """
from contextlib import contextmanager

@contextmanager
def halving():
    yield lambda number: number / 2
"""
WANT = "probably out of memory; use fewer processes: `jobs`"


def test_a_process_that_dies_is_started_anew_and_dying_twice_gives_none(tmp_path):
    marks = tmp_path / "died"
    with RestartingWorker(partial(halving, marks)) as work:
        assert [work(number) for number in (4, 0, 2, 13, 6)] == [2, 0, 1, None, 3]
    assert marks.with_suffix(".closed").exists()


def test_being_killed_for_memory_is_no_result_of_the_work(tmp_path):
    make_work = partial(halving, tmp_path / "a")
    with pytest.raises(UserError, match=WANT), RestartingWorker(make_work) as work:
        work(5)


def test_errors_of_the_work_are_raised_and_the_next_item_goes_on(tmp_path):
    with RestartingWorker(partial(halving, tmp_path / "died")) as work:
        with pytest.raises(TypeError):
            work("text")
        assert work(4) == 2


def test_what_cannot_be_made_in_the_process_is_said():
    with pytest.raises(UserError, match="this cannot be made"), RestartingWorker(refusing):
        pass
    with pytest.raises(UserError, match="while it started"), RestartingWorker(dying):
        pass


def test_a_result_that_cannot_be_read_is_not_the_end_of_its_process():
    with Worker(unreadable) as work:
        process = work("ask")
        with pytest.raises(FileNotFoundError, match="/no/such/file"):
            work("result")
        assert work("ask") == process


def test_a_file_that_ends_while_a_worker_starts_is_not_the_end_of_its_process():
    with pytest.raises(EOFError, match="the weights are cut off"):
        Worker(ending_a_file).start()


def test_a_worker_whose_module_is_missing_in_its_process_says_so(monkeypatch):
    module = types.ModuleType("only_here")
    exec(MODULE, module.__dict__)  # noqa: S102 (as a plugin is)
    monkeypatch.setitem(sys.modules, "only_here", module)
    worker = Worker(module.halving)
    with pytest.raises(UserError, match=r"put it into a module of its own.*'only_here'"):
        worker.start()
    assert not worker.running


def test_a_worker_that_was_killed_is_not_started_anew(tmp_path):
    worker = Worker(partial(halving, tmp_path / "died"))
    worker.kill()
    with pytest.raises(WorkerDiedError, match="has been stopped"):
        worker(4)
    assert not worker.running
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_pickled_is_told_as_text_and_is_no_crash():
    with RestartingWorker(raising) as work:
        process = work("ask")
        with pytest.raises(UserError, match=r"^a\.h5: damaged$"):
            work("user")
        with pytest.raises(RuntimeError, match=r"^LocalError: what went wrong$"):
            work("local")
        with pytest.raises(TypeError, match=r"cannot pickle '_thread\.lock'"):
            work("result")
        assert work("ask") == process
    with pytest.raises(RuntimeError, match="no such engine"), RestartingWorker(not_starting):
        pass


def test_a_process_that_takes_too_long_is_ended_and_counts_as_one_that_died(
    tmp_path, caplog, monkeypatch
):
    monkeypatch.setattr(Worker.stop, "__defaults__", (0.5,))  # seconds
    marks = tmp_path / "overslept"
    before = time.monotonic()
    with RestartingWorker(partial(sleeping, marks), limit=0.5) as work:
        assert [work(number) for number in (4, 0, 13, 6)] == [2, 0, None, 3]
        marks.with_suffix(".last").touch()
    assert time.monotonic() - before < 200
    assert caplog.text.count("did not answer within 0.5 s") == 3


def test_a_worker_says_how_it_ended_and_starts_anew(tmp_path):
    with Worker(partial(halving, tmp_path / "died"), name="the divider") as work:
        with pytest.raises(WorkerDiedError, match=r"^the divider ended with status -6$"):
            work(13)
        assert not work.running
        assert work(4) == 2
    with Worker(partial(sleeping, tmp_path / "slept"), limit=0.5) as work:
        with pytest.raises(WorkerTimeoutError, match=r"did not answer within 0\.5 s"):
            work(13)
        assert work(4) == 2


def test_a_worker_that_takes_too_long_to_start_is_ended():
    with pytest.raises(UserError, match=r"the sleeper was not ready within 0\.2 s"):
        Worker(partial(time.sleep, 600), start_limit=0.2, name="the sleeper").start()
