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


def test_an_error_inside_the_loop_is_not_swallowed():
    def work():
        for item in progress([1], "working", 1):
            raise ValueError(item)

    with pytest.raises(ValueError, match="1"):
        work()
