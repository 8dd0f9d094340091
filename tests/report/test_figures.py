import re
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pandas as pd
import pytest

from egad.report import figures, style
from egad.tables.evaluation import TRIALS
from egad.trials.statistics import trial_grid

SVG = "{http://www.w3.org/2000/svg}"


def texts(svg: str) -> list[str]:
    root = ElementTree.fromstring(svg)  # noqa: S314
    return ["".join(element.itertext()).strip() for element in root.iter(f"{SVG}text")]


@pytest.fixture(scope="module")
def heat_map(trials) -> str:
    return figures.trial_heat_map(trial_grid(trials, 7, 7), 7, 7, {"A0", "C4", "G6"})


def test_heat_map_tells_the_rates_of_objects_rows_and_columns(heat_map):
    shown = texts(heat_map)
    assert shown.count("75") == 3  # A0, its row and its column
    assert shown.count("0/20") == 1
    assert shown.count("38") == 1  # 15 of 40
    assert "24\N{EN DASH}53" in shown
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


def test_figures_are_the_same_every_time_and_undated(heat_map, trials, grasps):
    again = figures.trial_heat_map(trial_grid(trials, 7, 7), 7, 7, {"A0", "C4", "G6"})
    assert again == heat_map
    for draw in (
        lambda: figures.grasp_distributions({"yumi": grasps}),
        lambda: figures.outcome_bars({"yumi": trials}),
    ):
        first = draw()
        assert first == draw()
        assert "date" not in first.lower()


def test_outcome_bars_name_what_happened(trials):
    shown = texts(figures.outcome_bars({"a_b, c": trials}))
    assert {"a_b, c", "success", "no grasp", "15", "12", "8", "5"} <= set(shown)
    assert "collided" not in shown


def test_every_outcome_of_the_schema_has_its_own_colour():
    meaning = TRIALS.field("outcome").metadata[b"meaning"].decode()
    assert set(figures.OUTCOMES) == set(meaning.replace(" or ", ", ").split(", "))
    assert len(set(figures.OUTCOMES.values())) == len(figures.OUTCOMES)


@pytest.mark.parametrize("quality", [[], [np.nan, np.nan], [0.0, 0.0], [-0.001, 0.002]])
def test_distributions_of_odd_values(quality):
    grasps = pd.DataFrame({"quality": quality, "robust_quality": quality}, dtype=float)
    assert "share of the grasps" in texts(figures.grasp_distributions({"yumi": grasps}))


def test_comparison_marks_what_is_published(report):
    shown = texts(figures.comparison_chart(report.comparison))
    assert {"egad", "mine", "EGAD, 2020 (published)", "YCB (published)"} <= set(shown)


def test_colour_scale_is_viridis_clipped():
    ends = [matplotlib.colors.to_hex(matplotlib.colormaps["viridis"](end)) for end in (0.0, 1.0)]
    assert [style.scale_colour(value, 0.1, 0.3) for value in (0.1, 0.3)] == ends
    assert [style.scale_colour(value, 0.1, 0.3) for value in (-1, 7)] == ends
    assert style.scale_colour(float("nan"), 0.1, 0.3) == style.UNKNOWN
    assert re.fullmatch("#[0-9a-f]{6}", style.scale_colour(0.2, 0.2, 0.2))


def test_ink_contrasts_with_its_ground():
    assert style.ink_on("#ffffff") == style.INK
    assert style.ink_on("#08306b") == "white"
