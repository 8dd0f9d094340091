import numpy as np
import pandas as pd
import pytest

from egad.measures import MeasureSpace
from egad.report.evolution import coverage_curves, coverage_history, re_evaluation
from egad.tables.evolution import HISTORY

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
def history():
    """Two epochs of two islands and two steps."""
    places = [(e, i, s) for e in (0, 1) for i in (0, 1) for s in (0, 1)]
    rows = [step(e, i, s, 1 + 4 * e + 2 * s + i) for e, i, s in places]
    return pd.DataFrame(rows)[HISTORY.names]


def test_steps_of_islands_count_together_and_the_fullest_is_shown(history):
    run = coverage_history(history)
    assert run["offspring"].tolist() == [20, 40, 60, 80]
    assert (50 * run["coverage"]).round().tolist() == [2, 4, 6, 8]


def test_curves_name_the_runs_and_are_the_same_again(history):
    svg = coverage_curves({"paper": history, "sparse": history})
    assert "paper" in svg
    assert "sparse" in svg
    assert svg == coverage_curves({"paper": history, "sparse": history})
    assert "paper" not in coverage_curves({"paper": history})


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
