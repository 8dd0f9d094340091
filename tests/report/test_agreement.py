"""The section of labelled grasps tells what the table does."""

import numpy as np
from svg_text import texts

from egad.bench.stats import Area, Rate, reliability
from egad.report.agreement import agreement as viewed
from egad.report.agreement import agreement_chart


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


def test_the_report_shows_it(report_html):
    assert report_html.count('id="agreement"') == 1
    assert "38 could be carried out with the" in " ".join(report_html.split())
