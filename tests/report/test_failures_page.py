"""The numbers on the page of failures, counted by hand."""

import re

import numpy as np
import pandas as pd
import pytest
from partial_tables import fill_columns

from egad.bench.failures.features import ExplainedShare, ShapeFeature
from egad.evolution.voxels import pack
from egad.measures import MeasureSpace
from egad.report.axes import USUAL
from egad.report.failures import (
    AttemptFilm,
    Example,
    FeatureShare,
    SearchText,
    failure_labels,
    page,
    reasons_of,
    worst,
)
from egad.tables.failures import EXAMINED, FAILURE_ATTEMPTS, FAILURES

VOXELS = pack(np.ones((25, 25, 25), bool))
CONTACT = "A contact of more than 20 N on the way: the attempt fails"
SEARCH = SearchText("mine", "jaws", "above", CONTACT, ("mujoco", "pybullet"), 0.8, 0.5, 0.95)
FILMS = {"detector": AttemptFilm("missed", b"webp"), "reference": AttemptFilm("success")}
COUNTS = {"n_explained": 6, "n_nothing": 1, "n_not_chosen": 2, "n_none_good": 3}


def failure(name, column, row, difference, **more):
    pairs = {"n_pairs_mujoco": 10, "reference_successes_mujoco": 10}
    known = {"id": name, "complexity_cell": column, "difficulty_cell": row, "voxels": VOXELS}
    differences = {"difference_mujoco": difference, "difference_pybullet": 1.0}
    return known | differences | pairs | COUNTS | more


def feature(title, share=0.2, interval=(0.1, 0.3)):
    values = np.linspace(0, 1, 20)
    explained = ExplainedShare(0.1, 0.9, 0, 0, share, *interval)
    return FeatureShare(ShapeFeature(title, "mm", 1, "what it is"), explained, values, values)


@pytest.fixture
def tables():
    table = fill_columns(FAILURES, [failure("a", 1, 2, 0.9), failure("b", 3, 2, 0.8)])
    verdicts = ["failure"] * 2 + ["detector_succeeds"] * 5 + ["not_graspable", "cell_full"]
    examined = fill_columns(
        EXAMINED,
        [
            {"verdict": verdict, "source": "archive" if number % 2 else "child"}
            | {"attempts": 0 if verdict == "cell_full" else 10}
            for number, verdict in enumerate(verdicts)
        ],
    )
    return table, examined, fresh_attempts()


def fresh_attempts():
    """Of a: missed twice, collided once; of b: collided twice; of c, no failure: dropped."""
    lost = [("a", "missed"), ("a", "missed"), ("a", "collided"), ("a", "success")]
    lost += [("b", "collided"), ("b", "collided"), ("c", "dropped")]
    rows = [
        {"id": name, "purpose": "confirm", "engine": "mujoco", "who": "detector"}
        | {"outcome": outcome, "success": outcome == "success", "drop": number}
        for number, (name, outcome) in enumerate(lost)
    ]
    rows += [row | {"who": "reference", "outcome": "success", "success": True} for row in rows]
    return fill_columns(FAILURE_ATTEMPTS, [*rows, {"id": "a", "purpose": "screen"}])


def made_page(tables, **changed):
    known = {
        "search": SEARCH,
        "dataset": pd.DataFrame({"complexity": [2.0], "graspability": [0.002]}),
        "features": [feature("thickness")],
        "examples": {"a": Example(b"png", FILMS)},
        "space": MeasureSpace(),
        "axes": USUAL,
    }
    return page(*tables, **known | changed)


def words(html):
    """The text of a page without its tags."""
    return " ".join(re.sub(r"<[^>]*>", " ", html.partition("<body>")[2]).split())


def test_the_page_says_in_words_what_was_found(tables):
    text = words(made_page(tables)).replace("\N{NO-BREAK SPACE}", " ")
    assert "found 2 failures in 2 cells of the map, with 80 simulated grasps of 8 objects" in text
    assert "detector succeeds the detector holds it too often for a failure 5 55.6 %" in text
    assert "cell full not tried: its cell was full of failures 1 11.1 %" in text
    assert "Of 4 objects tried from the dataset, 1 is a failure (25.0 %)" in text
    assert "In 12 drops" in text
    assert "none of its first ten proposals holds: 6 (50 %)" in text
    assert "collided 3 1 failure" in text
    assert "missed 2 1 failure" in text
    assert "Lost: missed 2, collided 1." in text


def test_labels_are_those_that_loading_gives(tables):
    table = fill_columns(
        FAILURES,
        [failure("a", 3, 2, 1.0, slot=1), failure("b", 3, 2, 1.0, slot=0), failure("c", 0, 4, 1.0)],
    )
    assert list(failure_labels(table)) == ["C03_1", "C03_0", "E00_0"]
    assert "C01_0" in words(made_page(tables))


@pytest.mark.filterwarnings("error")
def test_a_feature_that_all_solved_objects_share_is_drawn(tables):
    size = feature("size")
    explained = size.share._replace(low=0.5, high=0.5)
    alike = size._replace(share=explained, solved=np.full(20, 0.5))
    assert "size" in words(made_page(tables, features=[alike]))


def test_names_are_escaped(tables):
    text = made_page(tables, search=SEARCH.__class__("<b>x</b>", *list(vars(SEARCH).values())[1:]))
    assert "<b>x</b>" not in text


def test_a_page_without_failures_says_so(tables):
    empty = pd.DataFrame(columns=FAILURES.names)
    text = made_page((empty, *tables[1:]), features=[], examples={})
    assert "The search found no failure" in words(text)
    assert "By shape" not in text


def test_a_missing_film_has_a_caption_alone(tables):
    text = made_page(tables)
    assert text.count("data:image/webp") == 1
    assert len(re.findall("<figcaption>", text)) == 2


def test_the_worst_come_first_and_at_most_two_of_a_cell():
    rows = [failure(name, 1, 1, 0.9) for name in "abc"] + [failure("d", 2, 2, 0.7)]
    rows += [failure("e", 3, 3, 0.95), failure("f", 1, 1, 0.92)]
    table = fill_columns(FAILURES, rows)
    assert list(worst(table, 20)["id"]) == ["e", "f", "a", "d"]
    assert list(worst(table, 2)["id"]) == ["e", "f"]


def test_reasons_are_shares_of_all_drops():
    table = fill_columns(FAILURES, [failure("a", 0, 0, 1.0), failure("b", 0, 0, 1.0, n_nothing=0)])
    assert [(each.drops, round(each.share, 3)) for each in reasons_of(table)] == [
        (1, 0.083),
        (4, 0.333),
        (6, 0.5),
    ]
    assert reasons_of(fill_columns(FAILURES, [{"id": "a"}])) == []
