import dataclasses

import numpy as np
import pandas as pd
import pytest

from egad.cli.terminal_tables import measured
from egad.measures import CustomMeasures, MeasureSpace
from egad.measures.grid import complexity_cells, difficulty_cells, labels
from egad.report.axes import USUAL, axis_pair
from egad_workflow.report_page import build

OWN = CustomMeasures(complexity="a.py:wall_thickness", graspability="b.c:slenderness")


def test_the_usual_axes_are_those_of_the_paper():
    assert axis_pair(CustomMeasures()) == USUAL
    assert USUAL.across.long_label == "shape complexity: simple → complex"
    assert USUAL.upwards.long_label == "grasp difficulty: easy → hard"


def test_an_own_measure_gives_its_name_and_the_other_axis_stays():
    across, upwards = axis_pair(OWN)
    assert across.label == "wall thickness: low → high"
    assert upwards.label == "slenderness: high → low"
    assert (upwards.factor, across.unit) == (1, "")
    assert axis_pair(CustomMeasures(complexity="a.py:f")).upwards == USUAL.upwards


@pytest.fixture(params=[10, 26])
def own_report(report, request):
    """The report of a run with measures and cells of one's own."""
    space = MeasureSpace(
        cells=request.param, complexity_range=(-2, 9), graspability_range=(0, 0.01)
    )
    settings = report.settings.model_copy(update={"measures": OWN, "space": space})

    def placed(data):
        objects = data.objects.assign(
            complexity_cell=complexity_cells(data.objects["complexity"], space),
            difficulty_cell=difficulty_cells(data.objects["graspability"], space),
        )
        names = labels(objects["complexity_cell"], objects["difficulty_cell"])
        return dataclasses.replace(data, objects=objects.assign(label=names), history=None)

    datasets = {name: placed(data) for name, data in report.datasets.items()}
    return dataclasses.replace(report, settings=settings, datasets=datasets)


def test_the_report_names_own_axes_and_has_all_cells(own_report):
    page = build(own_report)
    assert "wall thickness: low → high (-2 to 9)" in page
    assert "slenderness: high → low (0.01 to 0)" in page
    assert "simple → complex" not in page
    assert "easy → hard" not in page
    last = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"[own_report.settings.space.cells - 1]
    assert f'text-anchor="end">{last}</text>' in page


def test_tables_on_the_terminal_name_them(capsys):
    row = {"name": "a", "complexity": 1.5, "graspability": 0.25, "grasps": 0}
    row |= {"graspability_std": np.nan, "cell_confidence": np.nan}
    table = pd.DataFrame([row | {"complexity_cell": 3, "difficulty_cell": 25}])
    measured(table, axis_pair(OWN))
    said = capsys.readouterr().out
    measured(table, USUAL)
    titles = capsys.readouterr().out.splitlines()[0]
    assert titles.split() == ["name", "complexity,", "bit", "graspability,", "1e-3", "cell"]
    assert "wall thickness  slenderness" in said
    assert "0.250" in said
    assert "Z03" in said
