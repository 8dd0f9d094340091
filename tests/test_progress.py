import itertools

import pytest

from egad import progress as module
from egad.progress import progress


def test_items_pass_through_and_a_log_gets_a_line_now_and_then(monkeypatch, capsys):
    clock = itertools.count(step=20)
    monkeypatch.setattr(module.time, "monotonic", lambda: next(clock))
    assert list(progress(iter("abcd"), "working", 4)) == list("abcd")
    lines = capsys.readouterr().err.splitlines()
    assert lines == ["working: 2/4, 0.1/s, 40 s left", "working: 4/4, 0.1/s, 0 s left"]


def test_a_line_counts_what_an_item_holds_and_says_how_things_stand(monkeypatch, capsys):
    clock = itertools.count(step=40)
    monkeypatch.setattr(module.time, "monotonic", lambda: next(clock))
    list(progress([1, 2], "evaluations", 2, scale=100, state=lambda: "coverage 0.81"))
    assert capsys.readouterr().err.splitlines() == [
        "evaluations: 100/200, 2.5/s, 40 s left, coverage 0.81",
        "evaluations: 200/200, 2.5/s, 0 s left, coverage 0.81",
    ]


def test_a_terminal_gets_a_bar(monkeypatch, capsys):
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    assert list(progress("abc", "working", 3, state=lambda: "coverage 0.81")) == list("abc")
    assert "100%" in capsys.readouterr().err


def test_an_error_inside_the_loop_is_not_swallowed():
    def work():
        for item in progress([1], "working", 1):
            raise ValueError(item)

    with pytest.raises(ValueError, match="1"):
        work()
