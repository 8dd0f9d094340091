"""The pictures of attempts in docs."""

import runpy
from pathlib import Path

import numpy as np
import pandas as pd

PICTURES = Path(__file__).with_name("pictures.py")


def test_typical_failures_are_those_of_the_object_that_is_lost_most():
    typical = runpy.run_path(str(PICTURES))["typical"]
    rows = [
        *[("A0", "missed", 0.05)] * 2,
        *[("B1", "missed", 0.05)] * 3,
        *[("A0", "slipped_lifting", 0.05)] * 4,
        *[("C2", "no_grasp", np.nan)] * 9,
        *[("C2", "success", 0.05)] * 9,
    ]
    trials = pd.DataFrame(rows, columns=["label", "outcome", "width"])
    trials = trials.assign(success=trials["outcome"] == "success", attempt=range(len(trials)))
    found = typical(trials, "label", 0.01)
    assert found[["label", "outcome"]].to_numpy().tolist() == [
        ["B1", "missed"],
        ["A0", "slipped_lifting"],
    ]
    assert list(found["attempt"]) == [2, 5]
