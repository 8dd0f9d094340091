"""Simulated against real rates: published test vectors, a slow twin, and what must come out."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import pearsonr, spearmanr

from egad.bench.stats import NothingInCommonError, mmrv, prediction_powered_rate, validate

# success rates of SIMPLER: simulated (visual matching), then real, of the same policies in order
SIMPLER = {
    "pick coke can": (
        (0.787, 0.857, 0.710, 0.567, 0.027, 0.170),
        (0.907, 0.853, 0.920, 0.760, 0.133, 0.293),
    ),
    "move near": (
        (0.779, 0.442, 0.354, 0.317, 0.050, 0.042),
        (0.733, 0.633, 0.583, 0.450, 0.017, 0.350),
    ),
    "open drawer": (
        (0.157, 0.601, 0.463, 0.296, 0.000, 0.009),
        (0.333, 0.815, 0.704, 0.519, 0.000, 0.148),
    ),
    "close drawer": (
        (0.343, 0.861, 0.667, 0.891, 0.278, 0.444),
        (0.630, 0.926, 0.889, 0.741, 0.000, 0.519),
    ),
    "carrot": ((0.042, 0.083, 0.097), (0.000, 0.250, 0.083)),
}


def slow_mmrv(simulated, real):
    """As it is written down."""
    worst = []
    for i in range(len(real)):
        violation = 0.0
        for j in range(len(real)):
            if (simulated[i] > simulated[j]) != (real[i] > real[j]):
                violation = max(violation, abs(real[i] - real[j]))
        worst.append(violation)
    return np.mean(worst)


@pytest.mark.parametrize(
    ("task", "right", "swapped", "pearson"),
    [
        ("pick coke can", 0.0313, 0.0618, 0.975),
        ("move near", 0.1110, 0.0027, 0.856),
        ("open drawer", 0.0, 0.0, 0.983),
        ("close drawer", 0.1233, 0.1133, 0.771),
        ("carrot", 0.1113, 0.0093, 0.571),
    ],
)
def test_violations_are_those_of_published_tables(task, right, swapped, pearson):
    simulated, real = (np.array(rates) for rates in SIMPLER[task])
    assert mmrv(simulated, real) == pytest.approx(right, abs=6e-5)
    assert mmrv(real, simulated) == pytest.approx(swapped, abs=6e-5)
    found = validate(
        *({f"{i}": rates([each]) for i, each in enumerate(side)} for side in SIMPLER[task])
    )
    assert found.detectors.pearson.value == pytest.approx(pearson, abs=6e-4)
    assert found.detectors.mmrv.value == pytest.approx(right, abs=6e-5)


def rates(values, attempts=np.nan, first=0):
    labels = [f"{'ABCDEFGHIJ'[i // 10]}{i % 10}" for i in range(first, first + len(values))]
    columns = {"rate": np.array(values, dtype=float), "attempts": float(attempts)}
    return pd.DataFrame(columns, index=pd.Index(labels, name="label"))


def test_violations_are_those_of_a_slow_twin():
    rng = np.random.default_rng(0)
    for count in (1, 2, 7, 30):
        one, other = rng.integers(0, 6, (2, 40, count)) / 5  # with ties
        found = mmrv(one, other)
        assert found == pytest.approx([slow_mmrv(*pair) for pair in zip(one, other, strict=True)])
    large = rng.random((2, 3000, 60))
    assert mmrv(*large)[[0, 1700, 2999]] == pytest.approx(
        [slow_mmrv(large[0, i], large[1, i]) for i in (0, 1700, 2999)]
    )


def sampled(objects=40, detectors=3, noise=0.1, seed=0):
    """Rates that agree but for noise; the real ones are 0.2 lower."""
    rng = np.random.default_rng(seed)
    true = rng.uniform(0.3, 0.9, (detectors, objects)) + np.arange(detectors)[:, None] * 0.03
    near = np.clip(true - 0.2 + noise * rng.standard_normal(true.shape), 0, 1)
    return tuple({f"d{i}": rates(row) for i, row in enumerate(side)} for side in (true, near))


def test_agreement_over_objects_is_that_of_scipy():
    simulated, real = sampled()
    found = validate(simulated, real)
    assert list(found.objects) == ["d0", "d1", "d2"]
    for name, each in found.objects.items():
        one, other = simulated[name]["rate"], real[name]["rate"]
        assert each.count == 40
        assert each.spearman.value == pytest.approx(spearmanr(one, other).statistic)
        assert each.pearson.value == pytest.approx(pearsonr(one, other).statistic)
        assert each.mmrv.value == pytest.approx(slow_mmrv(one.to_numpy(), other.to_numpy()))
        assert each.difference.value == pytest.approx((other - one).mean())
        assert (each.simulated, each.real) == pytest.approx((one.mean(), other.mean()))
        for value, low, high in (each.spearman, each.pearson, each.difference):
            assert low < value < high
        assert each.difference.ci_low < -0.18 < each.difference.ci_high + 0.05


def test_intervals_of_correlations_hold_the_true_one(monkeypatch):
    monkeypatch.setattr("egad.bench.stats.rates.DRAWS", 400)
    held = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        one, other = rng.multivariate_normal([0.5, 0.5], np.array([[1, 0.7], [0.7, 1]]) / 100, 20).T
        found = validate({"x": rates(one)}, {"x": rates(other)}).objects["x"].pearson
        held.append(found.ci_low <= 0.7 <= found.ci_high)
    assert np.mean(held) >= 0.85


def test_detectors_are_ranked_over_the_objects_that_all_tried():
    simulated, real = sampled(objects=30)
    simulated["d1"] = simulated["d1"].drop(["A0", "A1"])
    real["d2"] = real["d2"].drop(["B3"])
    found = validate(simulated, real)
    common = [label for label in real["d0"].index if label not in ("A0", "A1", "B3")]
    means = [
        [side[f"d{i}"].loc[common, "rate"].mean() for i in range(3)] for side in (simulated, real)
    ]
    assert found.detectors.count == 3
    assert found.detectors.pearson.value == pytest.approx(pearsonr(*means).statistic)
    assert found.detectors.mmrv.value == pytest.approx(slow_mmrv(*means))
    assert found.detectors.spearman.value == pytest.approx(spearmanr(*means).statistic)
    assert found.detectors.mmrv.ci_low <= found.detectors.mmrv.ci_high
    assert "3 detectors are too few for correlations to say much" in found.notes
    assert found.objects["d1"].count == 28
    assert "d1: real objects that were not simulated: A0, A1" in found.notes


def test_few_attempts_limit_the_correlation_of_an_exact_simulation(monkeypatch):
    monkeypatch.setattr("egad.bench.stats.rates.DRAWS", 10)  # intervals are not looked at
    rng = np.random.default_rng(0)
    true = rng.beta(2, 1.5, 60)
    limits, seen = [], []
    for _ in range(12):
        one, other = (rates(rng.binomial(n, true) / n, n) for n in (100, 5))
        found = validate({"x": one}, {"x": other}).objects["x"]
        limits.append(found.limit)
        seen.append(found.pearson.value)
    assert np.mean(limits) == pytest.approx(np.mean(seen), abs=0.03)
    assert 0.6 < np.mean(limits) < 0.9
    unknown = validate({"x": one}, {"x": rates(other["rate"])}).objects["x"]
    assert np.isnan(unknown.limit)
    once = validate({"x": one}, {"x": other.assign(attempts=1.0)}).objects["x"]
    assert np.isnan(once.limit)


def test_objects_that_were_only_simulated_predict_the_real_rate():
    simulated, real = sampled(objects=60, detectors=1)
    real["d0"] = real["d0"].iloc[:20]
    found = validate(simulated, real)
    one, other = simulated["d0"]["rate"].to_numpy(), real["d0"]["rate"].to_numpy()
    assert found.predicted == {"d0": prediction_powered_rate(other, one[:20], one[20:])}
    assert found.objects["d0"].count == 20
    few = validate(simulated, {"d0": real["d0"].iloc[:4]})
    assert few.predicted == {}
    assert any("4 common objects are too few to predict" in note for note in few.notes)
    assert validate(real, real).predicted == {}


def test_one_detector_on_each_side_needs_no_common_name():
    simulated, real = sampled(detectors=1)
    found = validate({"ggcnn": simulated["d0"]}, {"results": real["d0"]})
    assert list(found.objects) == ["ggcnn"]
    assert found.detectors is None
    assert "one detector: it takes several" in found.notes[0]


def test_a_single_object_has_no_correlation():
    found = validate({"x": rates([0.5])}, {"x": rates([0.4])}).objects["x"]
    assert found.difference.value == pytest.approx(-0.1)
    assert np.isnan([*found.pearson, *found.spearman, found.difference.ci_low]).all()


def test_nothing_in_common_is_told():
    simulated, real = sampled(objects=8, detectors=2)
    with pytest.raises(
        NothingInCommonError, match="no detector is on both sides: simulated d0, d1; real a, b"
    ):
        validate(simulated, {"a": real["d0"], "b": real["d1"]})
    elsewhere = {name: rates([0.5] * 8, first=50) for name in real}
    with pytest.raises(
        NothingInCommonError,
        match=r"no object is on both sides: simulated A0, A1, .*, \.\.\.; real F0, F1, ",
    ):
        validate(simulated, elsewhere)
