import logging
from types import SimpleNamespace

import pytest

from egad._util.progress import marked
from egad_workflow.display import messages

RULES, ALL, REASON = (SimpleNamespace(name=name) for name in ("RULES", "ALL", "REASON"))


def test_starts_and_ends_of_jobs_take_a_line_each(start_run):
    run = start_run()
    run.send("Select jobs to execute...")
    run.send("Execute 1 jobs...", "job_started", jobs=[1])
    run.start(1, message="Evolving")
    run.finish(1)
    start, done = run.shown.splitlines()
    assert start.endswith("start evolve: Evolving")
    assert done.endswith("done  evolve: Evolving, 0:00 (1 of 5 steps)")


def test_a_job_without_a_message_is_called_by_its_rule(start_run):
    run = start_run()
    run.start(1, message=None)
    assert run.shown.endswith("start evolve: evolve\n")


def test_a_target_that_only_asks_for_files_is_not_a_job(start_run):
    run = start_run()
    run.start(1, rule="all", message=None, logged=False)
    run.finish(1)
    assert run.shown == ""
    run.finish(1, done=5)
    assert run.shown.endswith("done  all 5 steps\n")


def test_what_else_snakemake_says_is_kept(start_run):
    run = start_run()
    run.send("Trying to restart job 3.")
    run.send("WorkflowError:\nno", "error", logging.ERROR, exception="WorkflowError")
    assert run.shown.splitlines() == ["Trying to restart job 3.", "WorkflowError:", "no"]


def test_a_failed_job_shows_the_last_lines_of_its_log_once(start_run):
    run = start_run()
    run.start(1)
    run.log(1).write_text("".join(f"line {number} of it\n" for number in range(100)))
    run.fail(1)
    assert "Error in rule evolve" in run.shown
    assert "exit status 137" in run.shown
    assert "node: 7" in run.shown
    assert str(run.log(1)) in run.shown
    assert [run.shown.count(f"line {number} of it") for number in (99, 90, 50)] == [1, 1, 0]
    assert "long" not in run.shown


def test_marked_lines_of_a_log_are_shown(start_run):
    """As when a detector fails, and the run goes on."""
    run = start_run()
    run.start(1)
    run.log(1).write_text(f"trying: 1/2\n{marked('it failed:' + chr(10) + '  line 3')}\nthe end\n")
    run.finish(1)
    assert run.shown.splitlines()[-2:] == ["it failed:", "  line 3"]
    assert "the end" not in run.shown


def test_the_jobs_of_a_failed_group_are_gone(start_run):
    run = start_run()
    run.start(1)
    infos = [{"jobid": 1}]
    run.send("the group failed", "group_error", logging.ERROR, job_error_info=infos)
    run.finish(1)
    assert run.shown.splitlines()[1:] == ["the group failed"]


@pytest.mark.parametrize(("quiet", "shown"), [((), 1), ([REASON], 1), ([RULES], 0), ([ALL], 0)])
def test_a_quiet_run_has_no_display(start_run, quiet, shown):
    run = start_run(quiet=quiet)
    assert sum(isinstance(each, messages.Display) for each in run.logger.handlers) == shown


def test_another_logger_plugin_is_left_alone(monkeypatch):
    logger = logging.Logger("run")
    logger.addHandler(logging.NullHandler())
    monkeypatch.setattr(messages, "LOGGER", logger)
    messages.start_display(5)
    assert len(logger.handlers) == 1


@pytest.mark.parametrize("tty", [False, True])
def test_a_second_run_in_a_process_has_a_display_of_its_own(start_run, tty):
    run = start_run(tty)
    messages.start_display(5)
    assert sum(isinstance(each, messages.Display) for each in run.logger.handlers) == 1
    run.start(1)
    assert run.shown.count("start evolve") == 1


@pytest.mark.parametrize("tty", [False, True])
def test_after_the_end_the_terminal_is_as_it_was(start_run, tty):
    run = start_run(tty)
    run.logger.handlers[-1].close()
    assert run.handler.stream is run.stream
    run.logger.removeHandler(run.logger.handlers[-1])
    run.start(1)
    assert run.shown.endswith("long\n")
