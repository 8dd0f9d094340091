"""The plan of a session at a real robot, and what its page says without a browser."""

import json
import re
from collections import Counter
from itertools import groupby

import pytest

from egad.bench.stats import LOG_COLUMNS
from egad.errors import UserError
from egad.report.log_sheet import LogObject, attempt_order, order_table, page, plan
from egad.tables.outcomes import observable

LABELS = ["A0", "C4", "G6"]
OBJECTS = [LogObject(label, f"id-{label}", b"PNG") for label in LABELS]


def order(seed=0, labels=LABELS, detectors=("mine", "theirs")):
    return attempt_order(labels, 20, detectors, seed)


def test_detectors_alternate_in_blocks_at_one_object():
    """So that an attempt of one has its partner of the other just before or after it."""
    planned = order()
    for first, second in zip(planned[::2], planned[1::2], strict=True):
        assert first[:2] == second[:2]
        assert {first.detector, second.detector} == {"mine", "theirs"}
    firsts = Counter(each.detector for each in planned[::2])
    assert min(firsts.values()) > 20  # of 60


def test_objects_are_changed_as_rarely_as_can_be_and_attempts_are_in_their_order():
    planned = order()
    assert len([label for label, _ in groupby(planned, lambda each: each.label)]) == 3
    for label in LABELS:
        attempts = [each.attempt for each in planned if each.label == label]
        assert attempts == sorted(attempts)


def test_in_rounds_every_object_is_tried_by_all_before_any_is_tried_again():
    found = attempt_order(["A0", "B1", "C2"], 4, ["one", "two"], 5, rounds=True)
    assert len(set(found)) == len(found) == 24
    rounds = [found[start : start + 6] for start in range(0, 24, 6)]
    for number, each in enumerate(rounds):
        assert {attempt.attempt for attempt in each} == {number}
        labels = [attempt.label for attempt in each]
        assert labels[::2] == labels[1::2]  # both detectors at an object, then the next
        assert sorted(labels[::2]) == ["A0", "B1", "C2"]
    assert len({tuple(attempt.label for attempt in each) for each in rounds}) > 1


def test_the_order_is_that_of_the_seed():
    assert order() == order()
    assert order() == order(labels=LABELS[::-1], detectors=("theirs", "mine"))
    assert len({tuple(order(seed)) for seed in range(20)}) == 20
    objects = {tuple(dict.fromkeys(each.label for each in order(seed))) for seed in range(20)}
    assert len(objects) > 3


def test_an_object_has_the_same_order_whichever_others_there_are():
    alone = order(labels=["C4"])
    assert alone == [each for each in order() if each.label == "C4"]


def test_letters_hide_the_detectors_and_do_not_tell_their_order():
    names = ["mine", "theirs"]
    shown = [plan(LABELS, 1, names, seed, blind=True).shown for seed in range(20)]
    assert all(sorted(each.values()) == ["A", "B"] for each in shown)
    assert {each["mine"] for each in shown} == {"A", "B"}
    assert plan(LABELS, 1, names, 0, blind=False).shown == {"mine": "mine", "theirs": "theirs"}


@pytest.mark.parametrize(
    ("detectors", "words"),
    [
        (["mine", "mine"], "mine is named twice"),
        (["=1+1"], "'=1[+]1' cannot be the name of a detector; allowed: a letter or digit, then"),
        (["-"], "cannot be the name"),
        ([""], "cannot be the name"),
        (["two\nlines"], "cannot be the name"),
        (["x" * 61], "cannot be the name"),
        ([], "0 names; allowed: 1 to 26"),
        ([f"d{number}" for number in range(27)], "27 names; allowed: 1 to 26"),
    ],
)
def test_names_that_cannot_stand_in_a_table_are_refused(detectors, words):
    with pytest.raises(UserError, match=words):
        plan(LABELS, 1, detectors, 0, blind=False)


def test_no_attempts_are_no_session():
    with pytest.raises(UserError, match="--attempts 0 is not allowed"):
        plan(LABELS, 0, ["mine"], 0, blind=False)


def test_the_robot_gets_the_order_with_the_true_names():
    planned = plan(LABELS, 2, ["mine", "theirs"], 0, blind=True)
    table = order_table(planned, OBJECTS)
    assert table["order"].tolist() == list(range(1, 13))
    assert set(table["detector"]) == {"mine", "theirs"}
    assert (table["id"] == "id-" + table["label"]).all()
    rows = zip(table["label"], table["attempt"], table["detector"], strict=True)
    assert tuple(rows) == planned.order


def data_of(text):
    return json.loads(re.search(r'id="sheet">(.*?)</script>', text, re.DOTALL)[1])


def test_the_page_has_the_order_and_needs_no_other_file():
    planned = plan(LABELS, 2, ["mine", "theirs"], 0, blind=True)
    text = page(planned, OBJECTS, "results/egad")
    data = data_of(text)
    names = [each["name"] for each in data["detectors"]]
    found = [
        (data["objects"][item]["label"], attempt, names[detector])
        for item, attempt, detector in data["order"]
    ]
    assert tuple(found) == planned.order
    assert data["columns"] == list(LOG_COLUMNS)
    assert not re.search(r'(src|href)="(?!data:)', text)
    assert "://" not in text


def test_what_is_printed_has_letters_only():
    planned = plan(LABELS, 2, ["mine", "theirs"], 0, blind=True)
    text = page(planned, OBJECTS, "results/egad").partition('<script type="application/json"')[0]
    assert "mine" not in text
    assert "theirs" not in text
    rows = re.findall(r"<tr><td>(\d+)</td><td>(..)</td><td>(\d)</td><td>(.)</td>", text)
    expected = [
        (str(number), each.label, str(each.attempt + 1), planned.shown[each.detector])
        for number, each in enumerate(planned.order, 1)
    ]
    assert rows == expected


def test_the_same_plan_is_the_same_sheet():
    """A page that is written again finds what was logged on the one before."""

    def sheet(title="results/egad", seed=0, attempts=2, detectors=("mine", "theirs"), blind=True):
        planned = plan(LABELS, attempts, list(detectors), seed, blind=blind)
        return data_of(page(planned, OBJECTS, title))["sheet"]

    assert sheet() == sheet(title="elsewhere")
    others = {sheet(seed=1), sheet(attempts=3), sheet(detectors=["mine"]), sheet(blind=False)}
    assert len(others | {sheet()}) == 5


def test_names_do_not_break_the_page():
    planned = plan(["A0"], 1, ["a</script><b>&"], 0, blind=False)
    text = page(planned, OBJECTS[:1], "<i>title</i>")
    assert data_of(text)["detectors"][0]["name"] == "a</script><b>&"
    assert "<b>&" not in text
    assert "<i>title" not in text


def test_the_outcomes_are_those_of_the_gripper():
    jaws, cup = (set(observable(cup=cup)) for cup in (False, True))
    assert jaws ^ cup == {"no_seal", "missed", "slipped_closing"}
    assert "no_seal" in cup
    planned = plan(LABELS, 1, ["mine"], 0, blind=False)
    text = page(planned, OBJECTS, "objects", observable(cup=False))
    assert data_of(text)["outcomes"] == list(observable(cup=False))
    assert 'data-outcome="missed"' in text
    assert 'data-outcome="no_seal"' not in text
