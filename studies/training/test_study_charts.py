"""Charts of the training study."""

import re

from study_charts import Row, learning_chart, success_chart
from svg_text import texts

NOWHERE = (float("nan"), float("nan"))


def trained(*values):
    return Row(values, True, NOWHERE)


def heights(svg):
    """Where the filled dots of a chart are, from its top, in their order."""
    return re.findall(r'<use xlink:href="#\w+" x="[\d.]+" y="([\d.]+)" style="fill: #0072b2', svg)


def test_a_set_has_the_same_line_in_every_panel():
    """A test without one of the sets leaves its line empty."""
    every = {name: trained(0.9) for name in ("first", "second", "third")}
    full, part = (
        success_chart({"one": every, "other": {key: every[key] for key in keys}})
        for keys in (["first", "second", "third"], ["third"])
    )
    dots = [heights(svg) for svg in (full, part)]
    assert len(dots[0]) == 6
    assert dots[1][:3] == dots[0][:3]
    assert dots[1][3:] == dots[0][2:3]


def test_a_detector_below_the_axis_is_told_as_a_number():
    found = success_chart(
        {"test": {"set": trained(0.93, 0.84), "low": Row([0.31], False, NOWHERE)}}
    )
    said = texts(found)
    assert "\N{LEFTWARDS ARROW} 31%" in said
    assert {"80%", "100%"} <= set(said)
    assert "20%" not in said


def test_all_points_of_a_learning_curve_are_on_the_chart():
    found = learning_chart({"test": [(10, trained(0.55)), (100, trained(0.95))]}, "objects")
    said = texts(found)
    assert {"50%", "100%", "10", "100"} <= set(said)
    assert "40%" not in said
