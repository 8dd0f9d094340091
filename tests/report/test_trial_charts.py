"""Charts of trials tell what the tables do, and are the same every time."""

from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from svg_text import SVG, texts

from egad.bench.stats import Trend, object_positions, reliability, trial_grid
from egad.report.trial_charts import (
    outcome_chart,
    rate_bars,
    trial_chart,
    trial_heat_map,
)
from egad.report.trials import reliability_chart, trend_chart
from egad.tables.evaluation import RESULTS, TRIALS
from egad.tables.outcomes import CHARTED, Outcome

ROBOT = {"slipped", "other"}  # what people note of a robot


def named(table) -> set[str]:
    meaning = table.field("outcome").metadata[b"meaning"].decode()
    return set(meaning.replace(" or ", ", ").split(", "))


@pytest.fixture(scope="module")
def heat_map(trials) -> str:
    return trial_heat_map(trial_grid(trials, 7, 7), 7, 7, {"A0", "C4", "G6"})


def test_heat_map_tells_the_rates_of_objects_rows_and_columns(heat_map):
    shown = texts(heat_map)
    assert shown.count("75") == 3  # A0, its row and its column
    assert shown.count("0/20") == 1
    assert shown.count("38") == 1  # 15 of 40
    assert "0\N{EN DASH}75" in shown  # two objects tell little about others
    assert "53\N{EN DASH}89" in shown  # Wilson's interval of A0
    assert {"A", "G", "0", "6", "complexity: simple → complex"} <= set(shown)


def test_heat_map_marks_objects_without_attempts(heat_map):
    untried_rows_and_columns = 5 + 5
    assert texts(heat_map).count("\N{EN DASH}") == untried_rows_and_columns + 1  # and G6


def test_heat_map_puts_easy_objects_below(heat_map):
    root = ElementTree.fromstring(heat_map)  # noqa: S314
    height = {
        "".join(element.itertext()): float(element.get("y") or 0)
        for element in root.iter(f"{SVG}text")
        if element.get("y")
    }
    assert height["A"] > height["B"] > height["G"]


def test_outcome_bars_name_what_happened(trials):
    shown = texts(outcome_chart({"a_b, c": trials}))
    assert {"a_b, c", "success", "no grasp", "15", "12", "8", "5"} <= set(shown)
    assert "collided" not in shown


ELSEWHERE = {Outcome.SLIPPED_SHAKING, Outcome.NOT_RIGID}  # of labels, and of cleared tables


def test_every_outcome_of_the_schema_has_its_own_color():
    assert set(CHARTED) == named(TRIALS) | ROBOT == set(Outcome) - ELSEWHERE
    assert named(RESULTS) >= ROBOT
    assert len({each.color for each in CHARTED} - {""}) == len(CHARTED)


def drawn_charts(trials):
    grid = trial_grid(trials, 7, 7)
    objects = object_positions(trials)
    trend = Trend(-0.4, -0.6, -0.001)
    return {
        "heat map": trial_heat_map(grid, 7, 7, {"A0", "C4", "G6"}),
        "outcomes": outcome_chart({"one": trials, "two": trials}),
        "reliability": reliability_chart(reliability(trials)),
        "trends": trend_chart(
            objects,
            {"difficulty": trend, "complexity": Trend(np.nan, np.nan, np.nan)},
            {"difficulty": grid.rows, "complexity": grid.columns},
        ),
        "rows": rate_bars({"one": [*grid.rows, grid.overall]}),
    }


def test_charts_are_the_same_every_time_and_undated(trials):
    first = drawn_charts(trials)
    assert first == drawn_charts(trials)
    assert all("date" not in svg.lower() for svg in first.values())


def test_trends_are_told_with_their_interval(trials):
    shown = texts(drawn_charts(trials)["trends"])
    minus = "\N{MINUS SIGN}"
    assert f"rank correlation {minus}0.40 ({minus}0.60 to 0.00)" in shown
    assert "no rank correlation: too few objects, or all values are equal" in shown
    assert {"A", "G", "0", "6"} <= set(shown)


def test_screws_with_names_like_cells_are_in_no_grid(trials):
    shown = texts(trial_chart(trials.replace({"label": {"A0": "M3", "C4": "P1"}})))
    assert {"M3", "P1"} <= set(shown)
    assert "A" not in shown
    assert "A" in texts(trial_chart(trials))


@pytest.mark.parametrize("quality", [[0.0, 0.0], [5.0, 9.0], [-1.0, 0.3], [0.001, 0.003]])
def test_reliability_of_any_quality(quality):
    """A diagonal would mislead where quality is no chance; then there is none."""
    table = pd.DataFrame({"quality": quality, "success": [True, False]})
    svg = reliability_chart(reliability(table))
    assert "quality predicted by the detector" in texts(svg)
    assert "stroke-dasharray" not in svg


def test_a_diagonal_where_quality_can_be_a_chance():
    table = pd.DataFrame({"quality": [0.1, 0.9], "success": [True, False]})
    assert "stroke-dasharray" in reliability_chart(reliability(table))
