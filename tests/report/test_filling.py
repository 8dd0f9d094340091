import io

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from egad.pipeline.config import Space
from egad.report.filling import evaluations, filling_curves, filling_film
from egad.tables.evolution import HISTORY

SPACE = Space(cells=5, elites_per_cell=2)


def step(epoch, island, number, elites):
    cells = np.zeros(25, np.uint8)
    cells[:elites] = 1
    return {
        "epoch": epoch,
        "island": island,
        "step": number,
        "offspring": 10,
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
    run = evaluations(history)
    assert run["offspring"].tolist() == [20, 40, 60, 80]
    assert (50 * run["coverage"]).round().tolist() == [2, 4, 6, 8]


def test_curves_name_the_runs_and_are_the_same_again(history):
    svg = filling_curves({"paper": history, "sparse": history})
    assert "paper" in svg
    assert "sparse" in svg
    assert svg == filling_curves({"paper": history, "sparse": history})
    assert "paper" not in filling_curves({"paper": history})


def test_the_film_ends_with_the_last_map(history):
    film = Image.open(io.BytesIO(filling_film(history, SPACE)))
    assert film.n_frames == 4
    film.seek(3)
    last = np.asarray(film.convert("RGB"))
    unit = last.shape[1] // 5
    dark = last[unit // 2 : 5 * unit : unit, unit // 2 :: unit].sum(axis=2) < 700
    assert dark.sum() == 8
    assert dark[4].all()  # the easiest row is the lowest
    assert dark[3, :3].all()
