import re
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pandas as pd
import pytest

from egad.report import figures, style

SVG = "{http://www.w3.org/2000/svg}"


def texts(svg: str) -> list[str]:
    root = ElementTree.fromstring(svg)  # noqa: S314
    return ["".join(element.itertext()).strip() for element in root.iter(f"{SVG}text")]


def test_figures_are_the_same_every_time_and_undated(grasps, report):
    for draw in (
        lambda: figures.grasp_distributions({"yumi": grasps}),
        lambda: figures.comparison_chart(report.comparison),
    ):
        first = draw()
        assert first == draw()
        assert "date" not in first.lower()


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
