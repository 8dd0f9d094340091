"""The summary of simulated labels counts what was simulated, and nothing else."""

import numpy as np
import pandas as pd

from egad.grasps import simulated_graspability
from egad.tables.grasping import SIMULATED_OBJECTS


def test_shares_are_those_of_the_simulated_grasps():
    outcomes = ["success", "slipped_lifting", "missed", None, "success", "slipped_shaking", None]
    table = pd.DataFrame(
        {
            "label": list("BBBBAAC"),
            "id": list("bbbbaac"),
            "simulated_outcome": outcomes,
            "simulated_success": [None if each is None else each == "success" for each in outcomes],
            "simulated_engine": [None if each is None else "mujoco" for each in outcomes],
        }
    )
    found = simulated_graspability(table)
    assert list(found) == [*SIMULATED_OBJECTS.names[1::-1], *SIMULATED_OBJECTS.names[2:]]
    assert found["label"].tolist() == ["A", "B"]
    assert found["n_simulated"].tolist() == [2, 3]
    np.testing.assert_allclose(found["simulated_graspability"], [1 / 2, 1 / 3])
    np.testing.assert_allclose(found["held_shaking"], [1 / 2, 2 / 3])


def test_what_the_engine_could_not_tell_does_not_count():
    """An object with nothing else is not the hardest one: nothing is known about it."""
    table = pd.DataFrame(
        {
            "label": list("AAB"),
            "id": list("aab"),
            "simulated_outcome": ["success", "crashed", "failed"],
            "simulated_success": [True, None, None],
            "simulated_engine": "mujoco",
        }
    )
    found = simulated_graspability(table)
    assert found["label"].tolist() == ["A"]
    assert found["n_simulated"].tolist() == [1]
    assert found["simulated_graspability"].tolist() == [1.0]
