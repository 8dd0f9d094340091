import re

import pytest


@pytest.fixture(autouse=True)
def terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setenv("LINES", "24")
    monkeypatch.setenv("TERM", "xterm")


def plain(text):
    return re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", text)


def test_two_jobs_and_the_run_have_bars(start_run):
    run = start_run(tty=True)
    for number in (1, 2):
        run.start(number, message=f"Evolving island {number}")
        text = f"evaluations: {number}0/100, 5.00/s, 0:18 left, coverage 0.1{number}\n"
        run.log(number).write_text(text)
    (display,) = [each for each in run.logger.handlers if each is not run.handler]
    display._view._live.refresh()
    rows = plain(run.shown).splitlines()[-5:]
    assert rows[0].endswith("evolve: Evolving island 1")
    assert "10/100 evaluations, 5.00/s, 0:18 left, coverage 0.11, 0:00 so far" in rows[1]
    assert "20/100 evaluations" in rows[3]
    assert "0 of 5 steps, 2 running" in rows[4]


def test_what_is_said_meanwhile_stands_above_the_bars(start_run):
    run = start_run(tty=True)
    run.start(1)
    run.send("a warning")
    assert plain(run.shown).rindex("a warning") < plain(run.shown).rindex("0 of 5 steps")


def test_the_bars_fit_the_terminal_and_go_at_the_end(start_run):
    run = start_run(tty=True)
    for number in range(50):
        run.start(number)
    (display,) = [each for each in run.logger.handlers if each is not run.handler]
    rows = display._view._rows().renderables
    assert len(rows) < 24
    display.close()
    assert "\x1b[?25h" in run.shown[-200:]
