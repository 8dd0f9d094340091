"""The summaries of simulated grasps count what was simulated, and nothing else."""

import numpy as np
import pandas as pd
import pytest

from egad.sim import antipodal_success_rates, naive_success_rates
from egad.sim.success_rates import success_rate
from egad.tables import parquet
from egad.tables.grasping import ANTIPODAL_RATES, NAIVE_GRASPS, NAIVE_RATES


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
    found = antipodal_success_rates(table)
    assert list(found) == [*ANTIPODAL_RATES.names[1::-1], *ANTIPODAL_RATES.names[2:]]
    assert found["label"].tolist() == ["A", "B"]
    assert found["n_simulated"].tolist() == [2, 3]
    np.testing.assert_allclose(found["antipodal_success_rate"], [1 / 2, 1 / 3])
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
    found = antipodal_success_rates(table)
    assert found["label"].tolist() == ["A"]
    assert found["n_simulated"].tolist() == [1]
    assert found["antipodal_success_rate"].tolist() == [1.0]


def test_the_standard_error_is_that_of_resampled_grasps():
    rng = np.random.default_rng(0)
    for rate in (0.1, 0.5, 0.8):
        held = rng.uniform(size=160) < rate
        found = success_rate(np.where(held, "success", "missed"))
        means = rng.choice(held, size=(4000, len(held))).mean(axis=1)
        assert found.n == 160
        assert found.rate == held.mean()
        assert found.std == pytest.approx(means.std(), rel=0.05)
        assert found.std <= 0.04


def test_rates_in_free_space_and_on_the_table_are_apart():
    table = pd.DataFrame(
        {
            "label": list("BBBBBA"),
            "id": list("bbbbba"),
            "place": ["free", "free", "table", "table", "table", "free"],
            "outcome": ["success", "missed", "collided", "success", "failed", "crashed"],
            "engine": "mujoco",
        }
    )
    found = naive_success_rates(table)
    assert list(found) == NAIVE_RATES.names
    assert found["label"].tolist() == ["A", "B"]
    assert found["n_free"].tolist() == [0, 2]
    assert found["n_table"].tolist() == [0, 2]
    for column in ("simulated_success_rate", "table_success_rate"):
        np.testing.assert_array_equal(found[column], [np.nan, 0.5])
        np.testing.assert_allclose(found[f"{column}_std"], [np.nan, np.sqrt(1 / 8)])


def test_without_grasps_there_are_no_rates():
    assert len(naive_success_rates(parquet.empty(NAIVE_GRASPS))) == 0
