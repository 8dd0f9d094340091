"""Rates of cleared tables, by hand."""

import numpy as np
import pandas as pd
import pytest

from egad.bench.stats import by_difficulty, clearing_rates, compare_clearing
from egad.errors import UserError


def rows(scene, number, n_objects, outcomes, ids=None):
    return pd.DataFrame(
        {
            "scene": scene,
            "noise": "none",
            "round": number,
            "attempt": range(len(outcomes)),
            "present": " ".join(ids or []),
            "seed": f"{number:032x}",
            "objects": " ".join(f"object{each}" for each in range(n_objects)),
            "factors": "1.0 " * n_objects,
            "n_objects": n_objects,
            "success": [outcome == "success" for outcome in outcomes],
            "outcome": outcomes,
            "id": ids or [""] * len(outcomes),
        }
    )


def test_rates_are_those_of_the_papers():
    """No grasp is no attempt, but leaves objects behind."""
    table = pd.concat(
        [
            rows("pile", 0, 3, ["success", "missed", "success", "success"]),
            rows("pile", 1, 5, ["success", "no_grasp"]),
            rows("pile", 2, 2, ["no_grasp"]),
            rows("packed", 0, 2, ["error", "collided"]),
        ]
    )
    pile, packed = clearing_rates(table)
    assert (pile.scene, pile.noise, pile.rounds) == ("pile", "none", 3)
    assert (pile.success.successes, pile.success.attempts) == (4, 5)
    assert (pile.cleared.successes, pile.cleared.attempts) == (4, 10)
    assert (packed.success.value, packed.cleared.value) == (0, 0)
    for rate in (*pile[3:], *packed[3:]):
        low, high = rate.interval
        assert 0 <= low <= rate.value <= high <= 1


def test_a_detector_without_any_grasp_has_no_success_rate():
    only = clearing_rates(pd.concat([rows("pile", n, 3, ["no_grasp"]) for n in range(3)]))[0]
    assert np.isnan(only.success.value)
    assert only.success.interval == (0, 1)
    assert only.cleared.value == 0


def test_the_interval_is_as_wide_as_rounds_differ():
    """Rounds that are all right or all wrong tell less than attempts that are mixed."""
    mixed = [rows("pile", n, 2, ["success", "missed"]) for n in range(40)]
    split = [rows("pile", n, 2, ["success" if n % 2 else "missed"] * 2) for n in range(40)]
    narrow, wide = (clearing_rates(pd.concat(each))[0].success for each in (mixed, split))
    assert narrow.value == wide.value == 0.5
    assert np.ptp(wide.interval) > 1.3 * np.ptp(narrow.interval)


def test_thirds_by_difficulty_and_complexity():
    """A high graspability is easy."""
    objects = pd.DataFrame(
        {"id": list("abc"), "complexity": [1.0, 2.0, 3.0], "graspability": [0.1, 0.2, 0.3]}
    )
    table = rows("pile", 0, 3, ["success", "missed", "success"], ["a", "b", "c"])
    found = by_difficulty(table, objects).set_index(["axis", "band"])["successes"]
    assert found.loc["complexity"].to_list() == [1, 0, 1]
    assert by_difficulty(table, objects)["present"].to_list() == [1] * 6
    hardest = by_difficulty(rows("pile", 0, 1, ["success"], ["a"]), objects)
    assert hardest.set_index(["axis", "band"]).loc[("difficulty", 3), "attempts"] == 1


def test_attempts_without_an_object_count_in_no_third():
    objects = pd.DataFrame({"id": ["a"], "complexity": [1.0], "graspability": [0.1]})
    table = rows("pile", 0, 1, ["success", "error"], ["a", ""])
    assert by_difficulty(table, objects)["attempts"].sum() == pytest.approx(2)  # on two axes


def test_two_detectors_are_compared_over_the_rounds_that_both_played():
    first = [rows("pile", n, 4, ["success"] * 4) for n in range(20)]
    second = [rows("pile", n, 4, ["success", "missed", "success", "no_grasp"]) for n in range(20)]
    found = compare_clearing(pd.concat(first[:15]), pd.concat(second[5:]))
    assert len(found) == 1
    assert found[0].rounds == 10
    assert found[0].success == pytest.approx(1 - 2 / 3)
    assert found[0].cleared == pytest.approx(0.5)
    assert found[0].cleared_interval == pytest.approx((0.5, 0.5))  # all rounds are alike
    assert found[0].p_cleared == pytest.approx(2**-9)  # all of 10 coins on one side, either
    mirrored = compare_clearing(pd.concat(second), pd.concat(first))[0]
    assert mirrored.cleared == pytest.approx(-0.5)


def test_rounds_with_other_objects_are_not_compared():
    table = rows("pile", 0, 3, ["success"])
    with pytest.raises(UserError, match="no round in common"):
        compare_clearing(table, table.assign(objects="cup bowl"))
    with pytest.raises(UserError, match="no round in common"):
        compare_clearing(table, table.assign(factors="0.8 0.9 1.0"))


def test_what_the_engine_could_not_simulate_is_no_attempt():
    only = clearing_rates(rows("pile", 0, 3, ["success", "failed"]))[0]
    assert (only.success.successes, only.success.attempts) == (1, 1)
    assert only.cleared.value == pytest.approx(1 / 3)


def test_rounds_that_never_began_do_not_count():
    began = rows("pile", 0, 3, ["success", "missed", "missed"])
    broken = rows("pile", 1, 0, ["failed"])
    assert clearing_rates(pd.concat([began, broken])) == clearing_rates(began)
