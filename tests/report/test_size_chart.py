from xml.etree import ElementTree

import pandas as pd

from egad.report.size_chart import size_chart

SVG = "{http://www.w3.org/2000/svg}"


def words(svg):
    root = ElementTree.fromstring(svg)  # noqa: S314
    return ["".join(element.itertext()).strip() for element in root.iter(f"{SVG}text")]


def test_the_chart_names_objects_percentiles_and_axes(size_effect):
    found = words(size_chart(size_effect))
    assert {"A0", "G6", "percentile 65", "percentile 85", "possible"} <= set(found)
    assert found.count("percentile 65") == 1
    assert "smallest side / opening of the gripper" in found


def test_points_are_hollow_where_only_some_repetitions_found_grasps(size_effect):
    assert "fill: #ffffff; stroke: #0072b2" in size_chart(size_effect)
    whole = size_effect[size_effect["name"] == "A0"]
    assert "fill: #ffffff; stroke: #0072b2" not in size_chart(whole)


def test_an_object_without_any_grasp_has_an_empty_panel(size_effect):
    lonely = size_effect[size_effect["name"] == "A0"].assign(quality=float("nan"), possible=0)
    assert "A0" in words(size_chart(lonely))


def test_many_objects_wrap_into_rows_and_the_same_table_gives_the_same_bytes(size_effect):
    many = pd.concat([size_effect.assign(name=size_effect["name"] + str(n)) for n in range(2)])
    assert size_chart(many) == size_chart(many.copy())
    assert {"A00", "G60", "A01", "G61"} <= set(words(size_chart(many)))
