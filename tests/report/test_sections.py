"""What sections of the report tell, and their charts."""

import re

import matplotlib
import numpy as np
import pandas as pd
import pytest
from svg_text import texts

from egad.bench.stats import Area, Rate, reliability
from egad.grippers import GRIPPERS
from egad.measures import MeasureSpace
from egad.report import colors
from egad.report.agreement import agreement as viewed
from egad.report.agreement import agreement_chart
from egad.report.clutter import clutter_view
from egad.report.evaluation import evaluation_view
from egad.report.evolution import coverage_curves, coverage_history, re_evaluation
from egad.report.grasps import grasp_chart, grasp_numbers, size_chart
from egad.report.summary import DatasetSummary, name_stages, rejection_counts, section
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.evolution import HISTORY


def test_rejections_are_ordered_by_frequency(report):
    counts = rejection_counts(report.datasets["egad"].rejected)
    assert [row["count"] for row in counts] == [2, 1]
    assert counts[0]["reason"] == "no volume"


def test_it_is_said_what_an_object_is_left_out_of():
    stages = ["postprocess", "print-export panda", "bundle yumi", "other"]
    rejected = pd.DataFrame({"id": ["b", "a", "a", "c"], "stage": stages, "reason": "thin"})
    shown = name_stages(rejected)
    assert shown["id"].tolist() == ["a", "a", "b", "c"]
    words = ["printing for panda", "simulation for yumi", "the dataset", "other"]
    assert shown["stage"].tolist() == words


def test_dropped_bodies_are_counted_and_said(objects, settings):
    none = DatasetSummary(objects, settings.space, None, {})
    assert none.cut == 0
    bodies, volumes = np.zeros(40, int), np.zeros(40)
    bodies[:3], volumes[:3] = [1, 2, 1], [0.1, 0.48, 0.2]
    cut = objects.assign(dropped_bodies=bodies, dropped_volume=volumes)
    found = DatasetSummary(cut, settings.space, None, {})
    assert found.cut == 3
    shown = section({"parts": found}, 49).html
    assert "The meshes of 3 objects had several bodies" in shown
    assert "up to 48.0 % of the volume" in shown.replace("\N{NO-BREAK SPACE}", " ")
    assert "several bodies" not in section({"parts": none}, 49).html


SPACE = MeasureSpace(cells=5, elites_per_cell=2)


def step(epoch, island, number, elites):
    cells = np.zeros(25, np.uint8)
    cells[:elites] = 1
    return {
        "epoch": epoch,
        "island": island,
        "step": number,
        "offspring": 10,
        "refined": 5,
        "evaluated": 6,
        "empty": 3,
        "known": 1,
        "elites": elites,
        "coverage": elites / 50,
        "filled_cells": elites / 25,
        "qd_score": elites / 4 if number else np.nan,
        "cells": cells.tobytes(),
    }


@pytest.fixture
def islands():
    """Two epochs of two islands and two steps."""
    places = [(e, i, s) for e in (0, 1) for i in (0, 1) for s in (0, 1)]
    rows = [step(e, i, s, 1 + 4 * e + 2 * s + i) for e, i, s in places]
    return pd.DataFrame(rows)[HISTORY.names]


def test_steps_of_islands_count_together_and_the_fullest_is_shown(islands):
    run = coverage_history(islands)
    assert run["offspring"].tolist() == [20, 40, 60, 80]
    assert (50 * run["coverage"]).round().tolist() == [2, 4, 6, 8]


def test_curves_name_the_runs_and_are_the_same_again(islands):
    svg = coverage_curves({"paper": islands, "sparse": islands})
    assert "paper" in svg
    assert "sparse" in svg
    assert svg == coverage_curves({"paper": islands, "sparse": islands})
    assert "paper" not in coverage_curves({"paper": islands})


def test_re_evaluation_counts_moves_and_coverage():
    """Four objects selected for one cell; two lie beside it, on either side, one farther off."""
    space = MeasureSpace(cells=7, graspability_range=(0, 0.007), elites_per_cell=4)
    objects = pd.DataFrame(
        {
            "archive_graspability": [0.0055] * 4 + [np.nan],
            "complexity_cell": [2] * 5,
            "difficulty_cell": [1, 0, 2, 4, 0],
        }
    )
    found = re_evaluation(objects, space)
    assert (found.stayed, found.by_one, found.by_more) == (0.25, 0.5, 0.25)
    assert found.mean == 0.75
    assert found.before == found.after == 4 / 196
    assert re_evaluation(objects.tail(1), space) is None


def test_the_hardest_row_is_on_top_and_simple_objects_are_on_the_left():
    view = evaluation_view(parquet.empty(EVAL49), 3, 2, {}, (), GRIPPERS["panda"])
    labels = [[slot.label for slot in row] for row in view.slots]
    assert labels == [["C0", "C1"], ["B0", "B1"], ["A0", "A1"]]


def test_the_chart_names_objects_percentiles_and_axes(size_effect):
    found = texts(size_chart(size_effect))
    assert {"A0", "G6", "percentile 65", "percentile 85", "possible"} <= set(found)
    assert found.count("percentile 65") == 1
    assert "smallest side / opening of the gripper" in found


def test_points_are_hollow_where_only_some_repetitions_found_grasps(size_effect):
    assert "fill: #ffffff; stroke: #0072b2" in size_chart(size_effect)
    whole = size_effect[size_effect["name"] == "A0"]
    assert "fill: #ffffff; stroke: #0072b2" not in size_chart(whole)


def test_an_object_without_any_grasp_has_an_empty_panel(size_effect):
    lonely = size_effect[size_effect["name"] == "A0"].assign(quality=float("nan"), possible=0)
    assert "A0" in texts(size_chart(lonely))


def test_many_objects_wrap_into_rows_and_the_same_table_gives_the_same_bytes(size_effect):
    many = pd.concat([size_effect.assign(name=size_effect["name"] + str(n)) for n in range(2)])
    assert size_chart(many) == size_chart(many.copy())
    assert {"A00", "G60", "A01", "G61"} <= set(texts(size_chart(many)))


def test_the_grasp_chart_is_the_same_every_time_and_undated(grasps):
    svg = grasp_chart({"yumi": grasps})
    assert svg == grasp_chart({"yumi": grasps})
    assert "date" not in svg.lower()


@pytest.mark.parametrize("quality", [[], [np.nan, np.nan], [0.0, 0.0], [-0.001, 0.002]])
def test_distributions_of_odd_values(quality):
    grasps = pd.DataFrame({"quality": quality, "robust_quality": quality}, dtype=float)
    assert "share of the grasps" in texts(grasp_chart({"yumi": grasps}))


def test_grasp_numbers(grasps):
    found = grasp_numbers(grasps)
    assert (found.objects, found.grasps, found.per_object) == (40, 400, 10)
    assert found.collision_free == 0.25
    assert found.robust_success_rate == 0.5
    assert found.quality[1] == pytest.approx(grasps["quality"].median())


def test_grasps_that_could_not_be_carried_out_are_left_out_of_rates(agreement):
    found = viewed(agreement, 7)
    assert found.rates == [Rate(10, 20), Rate(0, 0), Rate(10, 18), *[Rate(0, 0)] * 4, Rate(20, 38)]
    assert found.outcomes == {"success": 20, "dropped": 18, "collided": 2}
    assert (found.labelled, found.free, found.objects) == (100, 60, 2)


def test_each_quality_has_an_area_over_all_and_in_each_row(agreement):
    found = viewed(agreement, 7)
    assert [len(each) for each in found.areas.values()] == [8, 8, 8]
    plain, robust = found.areas["nominal quality"], found.areas["robust quality"]
    assert (plain[-1].value, robust[-1].value) == (0.5, 1.0)
    assert [row for row in range(7) if not np.isnan(robust[row].value)] == [0, 2]


def test_a_table_of_nothing_but_collisions_has_no_areas(agreement):
    found = viewed(agreement.assign(outcome="collided", success=False), 7)
    assert found.rates[-1] == Rate(0, 0)
    assert np.isnan(found.areas["robust quality"][-1].value)
    assert "<svg" in found.svg


def test_the_chart_names_rows_and_qualities_and_is_the_same_every_time(agreement):
    bins = {"robust quality": reliability(agreement.assign(quality=agreement["robust_quality"]))}
    areas = {"robust quality": [Area(0.7, (0.6, 0.8)), Area(np.nan, (np.nan, np.nan))]}
    svg = agreement_chart(bins, areas)
    assert svg == agreement_chart(bins, areas)
    assert {"A", "all", "robust quality", "area under the ROC curve"} <= set(texts(svg))


def test_rates_and_thirds_are_those_of_the_table(clutter, evalset):
    view = clutter_view({"mine": clutter}, evalset, {})
    only = view.rates["mine"][0]
    assert (only.scene, only.noise, only.rounds) == ("pile", "none", 2)
    assert (only.success.successes, only.success.attempts) == (1, 5)
    assert (only.cleared.successes, only.cleared.attempts) == (1, 4)
    for rates in view.thirds["mine"].values():
        success, cleared = zip(*rates, strict=True)
        assert sum(rate.attempts for rate in success) == 5
        assert sum(rate.attempts for rate in cleared) == 4
        assert sum(rate.successes for rate in success) == 1
        assert [rate.successes for rate in success] == [rate.successes for rate in cleared]


def test_the_report_shows_labelled_grasps_and_cleared_tables(report_html):
    assert report_html.count('id="agreement"') == report_html.count('id="clutter"') == 1
    text = " ".join(report_html.split())
    assert "38 could be carried out with the" in text
    assert "A scene of the kind pile" in text
    assert "antipodal-cloud" in text


def test_color_scale_is_viridis_clipped():
    ends = [matplotlib.colors.to_hex(matplotlib.colormaps["viridis"](end)) for end in (0.0, 1.0)]
    assert [colors.scale_color(value, 0.1, 0.3) for value in (0.1, 0.3)] == ends
    assert [colors.scale_color(value, 0.1, 0.3) for value in (-1, 7)] == ends
    assert colors.scale_color(float("nan"), 0.1, 0.3) == colors.UNKNOWN
    assert re.fullmatch("#[0-9a-f]{6}", colors.scale_color(0.2, 0.2, 0.2))
