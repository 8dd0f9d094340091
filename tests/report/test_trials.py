"""Two detectors side by side, and the page of trials alone."""

import numpy as np
import pandas as pd
import pytest

from egad.errors import UserError
from egad.report.trials import EvaluationSet, page, pairs, trial_results
from egad.tables.evaluation import RESULTS

OUTCOMES = ("missed", "success")
SIMULATED = ("mujoco", "none", "collided")


def tried(name, rates, seed=0):
    rng = np.random.default_rng(seed)
    rows = [
        (label, label, n, bool(won), OUTCOMES[int(won)], rng.random(), name, f"{n}", *SIMULATED)
        for label, rate in rates.items()
        for n, won in enumerate(rng.random(20) < rate)
    ]
    return pd.DataFrame(rows, columns=RESULTS.names)


@pytest.fixture(scope="module")
def tables():
    labels = ["A0", "A1", "B0", "C2", "C3"]
    return {
        "poor": tried("poor", dict.fromkeys(labels, 0.3)),
        "good": tried("good", dict.fromkeys(labels, 0.9), 1),
        "elsewhere": tried("elsewhere", {"G6": 0.5}),
    }


def test_every_pair_that_can_be_compared_is_once_the_better_first(tables):
    (pair,) = pairs(tables)
    assert (pair.first, pair.second) == ("good", "poor")
    assert pair.result.difference > 0.3


def test_own_objects_have_a_bar_each_and_no_grid(tables):
    named = {
        name: table.assign(label="mug " + table["label"])
        for name, table in list(tables.items())[:2]
    }
    found = trial_results(named, EvaluationSet(7, 7))
    assert [view.objects for view in found.views] == [5, 5]
    assert not found.rows_figure
    assert found.outcome_figure
    assert all(view.heat_map and not view.trend_figure for view in found.views)
    shown = page(named, EvaluationSet(7, 7))
    assert "Success by difficulty" not in shown
    assert "Success by row" not in shown


def test_a_label_of_another_object_is_refused(tables):
    with pytest.raises(UserError, match="only trials of the same evaluation set can be compared"):
        pairs(tables | {"other": tables["poor"].assign(id="another")})


def test_each_detector_has_its_view(tables):
    found = trial_results(tables, EvaluationSet(7, 7))
    assert [view.name for view in found.views] == list(tables)
    assert [view.objects for view in found.views] == [5, 5, 1]
    assert {view.engine for view in found.views} == {"mujoco"}
    assert found.outcome_figure
    assert found.rows_figure
    alone = trial_results({"good": tables["good"]}, EvaluationSet(7, 7))
    assert [alone.outcome_figure, alone.rows_figure, alone.pairs] == ["", "", []]


def test_a_page_needs_no_other_file_and_is_the_same_every_time(tables):
    strange = {"<script>alert(1)</script>": tables["poor"], "good": tables["good"]}
    text = page(strange, EvaluationSet(7, 7))
    assert text == page(strange, EvaluationSet(7, 7))
    assert text.startswith("<!DOCTYPE html>")
    assert "<script>alert" not in text
    assert text.count("simulated in mujoco") == len(strange)
    assert "http" not in text.replace("http-equiv", "").split("<main>")[0]
    assert "good vs. &lt;script&gt;" in text


def test_a_detector_without_qualities_or_successes(tables):
    none = tables["poor"].assign(success=False, outcome="no_grasp", quality=np.nan)
    view = trial_results({"none": none}, EvaluationSet(7, 7)).views[0]
    assert view.reliability == ""
    assert np.isnan(view.discrimination)
    assert np.isnan(view.trends["difficulty"].rho)
    assert "0&nbsp;%" in page({"none": none}, EvaluationSet(7, 7)).replace(
        "\N{NO-BREAK SPACE}", "&nbsp;"
    )
