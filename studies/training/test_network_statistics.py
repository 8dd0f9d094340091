"""Training sets compared: against slow and obvious twins, and against what must come out."""

import numpy as np
import pandas as pd
import pytest
from network_statistics import (
    by_name,
    check_starts,
    compare_sets,
    difference,
    difference_interval,
    holm,
    mean_interval,
    network_rates,
    object_interval,
    pooled_spread,
)
from scipy import stats
from study_tables import CLEARED

from egad.bench.stats import clearing_rates
from egad.errors import UserError
from egad.tables import parquet

OBJECTS = [f"{letter}{digit}" for letter in "ABC" for digit in range(3)]
SETS = {"poor": (0.2, 2), "good": (0.8, 3), "given": (0.5, 1)}


def tried(name, seed, rate, rng, attempts=6):
    rows = [
        (name, seed, label, label, n, bool(rng.random() < rate), f"drop-{label}-{n}")
        for label in OBJECTS
        for n in range(attempts)
    ]
    columns = ["training_set", "seed", "label", "id", "attempt", "success", "initial_pose"]
    detector = f"{name}-{seed}" if name else "random"
    return pd.DataFrame(rows, columns=columns).assign(detector=detector, test="egad", noise="none")


@pytest.fixture(scope="module")
def table():
    rng = np.random.default_rng(1)
    networks = [
        tried(name, seed, rate, rng)
        for name, (rate, seeds) in SETS.items()
        for seed in range(seeds)
    ]
    return pd.concat([*networks, tried("", 0, 0.1, rng)], ignore_index=True)


def cleared(name, seed, rng, rounds=4):
    """Rounds of three objects; the last one has no attempt."""
    rows = [
        {"scene": scene, "noise": "none", "round": number, "attempt": n, "n_objects": 3}
        | {"objects": "a b c", "factors": "1 1 1", "success": bool(rng.random() < 0.5)}
        for scene in ("packed", "pile")
        for number in range(rounds)
        for n in range(1 if number == rounds - 1 else 4)
    ]
    frame = pd.DataFrame(rows).assign(
        test="egad", training_set=name, seed=seed, detector=f"{name}-{seed}"
    )
    frame["outcome"] = np.where(frame["success"], "success", "collided")
    last = frame["round"] == rounds - 1
    return frame.assign(
        success=frame["success"] & ~last, outcome=frame["outcome"].where(~last, "no_grasp")
    )


def test_every_network_has_its_own_rate_in_every_test(table):
    both = pd.concat([table, table.assign(noise="stereo", success=~table["success"])])
    found = network_rates(both, parquet.empty(CLEARED))
    assert len(found) == 2 * (2 + 3 + 1 + 1)
    for row in found.itertuples():
        chosen = both[(both["noise"] == row.noise) & (both["seed"] == row.seed)]
        names = chosen["training_set" if row.trained else "detector"]
        assert row.rate == chosen.loc[names == row.name, "success"].mean()
    assert list(by_name(found[found["noise"] == "none"])) == [*SETS, "random"]
    assert found.groupby("name")["trained"].first().to_dict() == {
        **dict.fromkeys(SETS, True),
        "random": False,
    }


def test_scenes_of_several_objects_have_the_rates_of_the_benchmark(table):
    rng = np.random.default_rng(2)
    tables = {seed: cleared("good", seed, rng) for seed in (0, 1)}
    found = network_rates(table, pd.concat(tables.values()))
    for seed, rows in tables.items():
        for rates in clearing_rates(rows):
            for measure in ("success", "cleared"):
                (one,) = found[
                    (found["scene"] == rates.scene)
                    & (found["measure"] == measure)
                    & (found["seed"] == seed)
                ]["rate"]
                assert one == getattr(rates, measure).value


def test_a_network_that_never_grasps_in_clutter_succeeds_in_nothing(table):
    rows = cleared("good", 0, np.random.default_rng(3), rounds=1)
    found = network_rates(table, rows)
    in_clutter = found[found["scene"] != "single"]
    assert len(in_clutter) == 4
    assert (in_clutter["rate"] == 0).all()


ONE, OTHER = [0.61, 0.66, 0.58, 0.63, 0.6], [0.52, 0.57, 0.5, 0.56]


def test_welch_by_hand():
    """Welch (1947) and Satterthwaite's degrees of freedom, written out."""
    found = difference(ONE, OTHER)
    parts = [np.var(each, ddof=1) / len(each) for each in (ONE, OTHER)]
    error = np.sqrt(sum(parts))
    freedom = sum(parts) ** 2 / sum(
        part**2 / (len(each) - 1) for part, each in zip(parts, (ONE, OTHER), strict=True)
    )
    gain = np.mean(ONE) - np.mean(OTHER)
    reach = stats.t.ppf(0.975, freedom) * error
    assert found.gain == pytest.approx(gain)
    assert found.interval == pytest.approx((gain - reach, gain + reach))
    assert found.p == pytest.approx(2 * stats.t.sf(gain / error, freedom))
    turned = difference(OTHER, ONE)
    assert (turned.gain, turned.p) == pytest.approx((-found.gain, found.p))
    assert turned.interval == pytest.approx((-found.interval[1], -found.interval[0]))


def test_a_single_network_is_a_fixed_number_for_the_others():
    found, turned = difference(ONE, [0.5]), difference([0.5], ONE)
    error = np.std(ONE, ddof=1) / np.sqrt(5)
    gain = np.mean(ONE) - 0.5
    assert found.p == pytest.approx(2 * stats.t.sf(gain / error, 4))
    reach = stats.t.ppf(0.975, 4) * error
    assert found.interval == pytest.approx((gain - reach, gain + reach))
    assert (turned.gain, turned.p) == pytest.approx((-found.gain, found.p))
    assert turned.interval == pytest.approx((-gain - reach, -gain + reach))
    alone = difference([0.7], [0.5])
    assert alone.gain == pytest.approx(0.2)
    assert np.isnan([alone.p, *alone.interval]).all()


def test_the_spread_is_that_within_sets():
    found = pooled_spread([[0.5, 0.56], [0.6, 0.64, 0.62], [0.9]])
    squares = 2 * 0.03**2 + 2 * 0.02**2
    assert found.freedom == 3
    assert found.sd == pytest.approx(np.sqrt(squares / 3))
    alone = pooled_spread([[0.5, 0.56]])
    assert alone.sd == pytest.approx(np.std([0.5, 0.56], ddof=1))
    assert pooled_spread([[0.5], [0.6]]) is None
    assert pooled_spread([]) is None


def test_intervals_cover_the_truth_in_19_of_20_cases():
    rng = np.random.default_rng(5)
    means, sizes = [0.5, 0.6, 0.8], [2, 8, 3]
    draws = [
        [rng.normal(mean, 0.03, size) for mean, size in zip(means, sizes, strict=True)]
        for _ in range(800)
    ]
    spreads = [pooled_spread(sets) for sets in draws]
    sd = [found.interval[0] < 0.03 < found.interval[1] for found in spreads]
    assert np.mean(sd) == pytest.approx(0.95, abs=0.025)
    ends = np.array(
        [mean_interval(sets[0], found) for sets, found in zip(draws, spreads, strict=True)]
    )
    assert np.mean((ends[:, 0] < 0.5) & (ends[:, 1] > 0.5)) == pytest.approx(0.95, abs=0.025)
    assert np.isnan(mean_interval([0.5], None)).all()
    wide = pooled_spread([[0.5, 1.0]])
    assert mean_interval([0.5, 1.0], wide) == (0.0, 1.0)  # rates
    assert np.isnan(mean_interval([0.5, 0.5], pooled_spread([[0.5, 0.5], [0.7, 0.7]]))).all()


def test_the_interval_of_a_difference_is_that_of_equal_variances():
    few, many = [0.5, 0.56], [0.6, 0.64, 0.65]
    expected = stats.ttest_ind(few, many).confidence_interval()
    found = difference_interval(few, many, pooled_spread([few, many]))
    assert found == pytest.approx((expected.low, expected.high))
    narrow = difference_interval(few, many, pooled_spread([few, many, [0.3, 0.31, 0.32]]))
    assert found[0] < narrow[0] < narrow[1] < found[1]
    assert np.isnan(difference_interval([0.5], [0.6], None)).all()


def test_pre_registered_comparisons_alone_are_corrected(table):
    both = pd.concat([table, table.assign(noise="stereo")])
    pairs = [("good", "poor"), ("good", "given"), ("good", "random")]
    found = compare_sets(both, pairs)
    assert [(each.first, each.second) for each in found] == 2 * pairs
    assert [each.noise for each in found] == ["none"] * 3 + ["stereo"] * 3
    assert [each.networks for each in found[:3]] == [(3, 2), (3, 1), (3, 1)]
    p_values = np.array([each.difference.p for each in found])
    assert [each.p_holm for each in found] == pytest.approx(holm(p_values))
    assert not compare_sets(both, [])


def test_a_second_network_that_answers_the_same_adds_no_certainty_about_objects(table):
    sets = {name: table[table["training_set"] == name] for name in SETS}
    one, other = (sets[name].query("seed == 0") for name in ("good", "poor"))
    twice = pd.concat([one, one.assign(seed=1)])
    found = object_interval(one, other)
    assert object_interval(twice, other) == pytest.approx(found)
    low, high = object_interval(other, one)
    assert (-high, -low) == pytest.approx(found)
    gain = one["success"].mean() - other["success"].mean()
    assert found[0] < gain < found[1]


def test_what_should_have_begun_alike_is_refused(table):
    moved = table[table["training_set"] == "poor"].copy()
    moved.iloc[:3, moved.columns.get_loc("initial_pose")] = "elsewhere"
    good = table[table["training_set"] == "good"]
    check_starts(table)
    with pytest.raises(UserError, match="poor-0 started attempt 0 at A0 with a different drop"):
        check_starts(pd.concat([good, moved]))
    check_starts(pd.concat([moved.assign(initial_pose=""), good]))


def rejected_by_holm(p_values, level):
    """The definition: in ascending order, reject until the first that is above level / left."""
    order = np.argsort(p_values)
    rejected = np.zeros(len(p_values), dtype=bool)
    for step, place in enumerate(order):
        if p_values[place] > level / (len(p_values) - step):
            break
        rejected[place] = True
    return rejected


@pytest.mark.parametrize("seed", range(5))
def test_holm_rejects_what_its_steps_reject(seed):
    p_values = np.random.default_rng(seed).beta(0.3, 2, size=15)
    corrected = holm(p_values)
    for level in np.random.default_rng(seed).uniform(0, 1, 50):
        assert ((corrected <= level) == rejected_by_holm(p_values, level)).all()


def test_holm_of_few():
    assert holm(np.array([0.03])).tolist() == [0.03]
    assert holm(np.array([])).tolist() == []
    assert holm(np.array([0.04, 0.01, 0.03])) == pytest.approx([0.06, 0.03, 0.06])
    assert holm(np.array([0.9, 0.8])).tolist() == [1.0, 1.0]
    assert holm(np.array([np.nan, 0.01])) == pytest.approx([np.nan, 0.02], nan_ok=True)
