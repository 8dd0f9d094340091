import itertools
import sys
import threading
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from egad._util import progress as module
from egad._util.progress import (
    Status,
    count_done,
    duration,
    parse_phase,
    phase,
    progress,
    rate_text,
    shared_progress,
)


class Clock:
    """A clock that goes on only when the work does."""

    def __init__(self):
        self.now = 0.0

    def work(self, seconds):
        for each in seconds:
            self.now += each
            yield each


@pytest.fixture
def logged(monkeypatch):
    """A job of the workflow, whose log others read."""
    monkeypatch.setenv(module.MARKS, "1")


@pytest.fixture
def clock(monkeypatch):
    made = Clock()
    monkeypatch.setattr(module.time, "monotonic", lambda: made.now)
    return made


def told(capsys):
    return [Status.parse(line) for line in capsys.readouterr().err.splitlines()]


@pytest.mark.usefixtures("logged")
def test_items_pass_through_and_a_log_tells_the_beginning_and_the_end(clock, capsys):
    assert list(progress(clock.work([0.1] * 4), "working", 4)) == [0.1] * 4
    assert [(each.what, each.done, each.total) for each in told(capsys)] == [
        ("working", 0, 4),
        ("working", 4, 4),
    ]


@pytest.mark.parametrize(("seconds", "lines"), [(14, []), (16, [15, 16]), (100, [15, 30, 60, 100])])
def test_people_get_no_line_for_short_work_and_few_for_long_work(clock, capsys, seconds, lines):
    list(progress(clock.work([1] * seconds), "working", seconds))
    assert [each.done for each in told(capsys)] == lines


@pytest.mark.usefixtures("logged")
def test_no_two_lines_are_more_than_ten_seconds_apart_nor_are_they_too_many(clock, capsys):
    list(progress(clock.work([0.25] * 4000), "working", 4000))
    times = [each.done / 4 for each in told(capsys)]
    gaps = [after - before for before, after in itertools.pairwise(times)]
    assert max(gaps) <= 10
    assert min(gaps[:-1]) >= 1
    assert len(times) < 130


@pytest.mark.usefixtures("logged")
def test_what_an_item_holds_and_how_things_stand_is_told(clock, capsys):
    list(progress(clock.work([40] * 4), "evaluations", 4, scale=100, state=lambda: "coverage 0.81"))
    statuses = told(capsys)
    assert [each.done for each in statuses] == [0, 100, 200, 300, 400]
    assert statuses[3] == Status("evaluations", 300, 400, pytest.approx(2.5), "coverage 0.81")
    assert statuses[3].left == pytest.approx(40)


@pytest.mark.usefixtures("logged")
@pytest.mark.parametrize("burst", [1, 2, 8])
def test_a_rate_is_told_once_enough_is_done_after_a_slow_start(clock, capsys, burst):
    """As when `burst` processes first compile kernels."""
    list(progress(clock.work([100, *[0.1] * (burst - 1), *[0.5] * 90]), "working", burst + 90))
    rates = [each.rate for each in told(capsys)]
    assert set(rates[:2]) == {0}
    assert all(1.9 < rate < 2 * (1 + burst / 8) for rate in rates if rate)
    assert rates[-1] == pytest.approx(2, rel=0.1)


@pytest.mark.usefixtures("logged")
def test_items_that_come_at_the_same_moment_give_no_endless_rate(clock, capsys):
    list(progress(clock.work([20, 0, 0, 0, 4, 4, 4]), "working", 10))
    assert [each.rate for each in told(capsys)][-1] == pytest.approx(3 / 12)


@pytest.mark.usefixtures("logged")
def test_the_rate_is_that_of_the_last_minute(clock, capsys):
    list(progress(clock.work([1] * 100 + [4] * 30), "working", 130))
    *_, last = told(capsys)
    assert last.rate == pytest.approx(1 / 4, rel=0.1)


@pytest.mark.usefixtures("logged")
def test_work_of_several_is_counted_together(monkeypatch, capsys):
    monkeypatch.setattr(module, "POLLING", 0.01)
    with shared_progress("attempts", 30) as file:
        threads = [threading.Thread(target=count_done, args=(file, 10)) for _ in range(3)]
        for each in threads:
            each.start()
        for each in threads:
            each.join()
    first, *_, last = told(capsys)
    assert (first.what, first.done, last.done, last.total) == ("attempts", 0, 30, 30)
    assert not file.exists()


@pytest.mark.usefixtures("logged")
def test_work_that_does_more_than_was_planned_or_fails_ends_the_display(capsys):
    with shared_progress("attempts", 5) as file:
        count_done(file, 7)
    assert told(capsys)[-1].done == 5
    with pytest.raises(ValueError, match="broken"), shared_progress("attempts", 5) as file:
        raise ValueError("broken")
    assert [each.done for each in told(capsys)] == [0]
    assert not [each for each in threading.enumerate() if each is not threading.main_thread()]


words = st.text("abc xyz-()", min_size=1).map(str.strip).filter(bool)
totals = st.integers(1, 10**6)


@given(words, totals, totals, st.floats(1e-3, 1e5), st.just("") | words)
def test_a_line_can_be_read_back(what, done, total, rate, state):
    written = Status(what, done, total, rate, state)
    found = Status.parse(str(written))
    assert (found.what, found.done, found.total, found.state) == (what, done, total, state)
    assert found.rate == pytest.approx(rate, rel=0.01)


@given(words, totals, st.just("") | words)
def test_a_line_without_a_rate_can_be_read_back(what, total, state):
    assert Status.parse(str(Status(what, 0, total, 0, state))) == Status(what, 0, total, 0, state)


@pytest.mark.parametrize("line", ["", "474 elites, coverage 0.190", "a: 3/", "egad: no such file"])
def test_other_lines_tell_no_progress(line):
    assert Status.parse(line) is None
    assert parse_phase(line) == ""


def test_a_phase_can_be_read_back(capsys):
    phase("writing meshes")
    (line,) = capsys.readouterr().err.splitlines()
    assert parse_phase(line) == "writing meshes"
    assert Status.parse(line) is None


@pytest.mark.parametrize(
    ("seconds", "text"), [(0, "0:00"), (59.6, "1:00"), (61, "1:01"), (3600, "1:00:00")]
)
def test_durations(seconds, text):
    assert duration(seconds) == text


@pytest.mark.parametrize(
    ("rate", "text"), [(123.4, "123/s"), (12.34, "12.3/s"), (0.5, "30.0/min"), (0.001, "3.60/h")]
)
def test_rates_have_three_digits_in_a_unit_that_suits_them(rate, text):
    assert rate_text(rate) == text


def test_a_terminal_gets_a_bar(monkeypatch, capsys):
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    assert list(progress("abc", "working", 3, state=lambda: "coverage 0.81")) == list("abc")
    assert "100%" in capsys.readouterr().err


def test_a_notebook_gets_one_line_that_moves(monkeypatch, clock, capsys):
    """As IPython shows it: a display that is made once and updated."""
    shown, updates = [], []

    def display(data, *, raw, display_id):
        assert raw
        assert display_id
        shown.append(data)
        return SimpleNamespace(update=lambda data, **_: updates.append(data["text/plain"]))

    shell = SimpleNamespace(kernel=object())
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(display=display))
    assert list(progress(clock.work([2] * 10), "working", 10)) == [2] * 10
    assert len(shown) == 1
    assert len(updates) == 11
    assert [line.partition(" ")[0].count("\N{FULL BLOCK}") for line in updates] == [
        *range(0, 21, 2)
    ]
    assert Status.parse(updates[-1].partition(" ")[2]).done == 10
    assert capsys.readouterr().err == ""


@pytest.mark.usefixtures("logged")
@pytest.mark.parametrize("shell", [None, SimpleNamespace()])
def test_a_prompt_of_ipython_is_no_notebook(monkeypatch, shell, capsys):
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    list(progress("ab", "working", 2))
    assert "working: 2/2" in capsys.readouterr().err


def test_slow_work_is_named_and_quick_work_is_not(monkeypatch, capsys):
    monkeypatch.setattr(module, "SLOW", 1.0)

    @module.phase_if_slow("thinking")
    def think(seconds):
        threading.Event().wait(seconds)
        return seconds

    assert think(0.0) == 0.0
    threading.Event().wait(1.5)
    assert capsys.readouterr().err == ""
    assert think(1.5) == 1.5
    assert capsys.readouterr().err == "thinking ...\n"
    with pytest.raises(ZeroDivisionError), module.phase_if_slow("failing"):
        1 / 0  # noqa: B018
