import numpy as np
import pandas as pd
import pytest
from svg_text import texts

from egad.report.grasps import grasp_chart, grasp_numbers, grasp_view, size_chart


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


def test_nothing_has_no_section():
    assert grasp_view({}, {}) is None
