"""What is compared in the study of failures as training data."""

import runpy
import sys
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import scipy.stats

EXPERIMENTS = Path(__file__).parents[2] / "experiments"
VERDICTS = [
    *(["failure"] * 3 + ["detector_succeeds"] * 6 + ["not_confirmed"] * 2),
    *(["not_graspable"] * 4 + ["cell_full"] * 3),
]


@contextmanager
def names_of(script):
    """What a script defines; the modules that it imports from its folder are forgotten again."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(EXPERIMENTS)
        yield runpy.run_path(str(EXPERIMENTS / script))
    for name in ("benchmark", "curriculum", "curriculum_tables", "failures"):
        sys.modules.pop(name, None)


@pytest.fixture(scope="module")
def study():
    with names_of("curriculum.py") as names:
        yield names


@pytest.fixture(scope="module")
def tables():
    with names_of("curriculum_tables.py") as names:
        yield names


@pytest.fixture
def examined():
    rng = np.random.default_rng(0)
    count = len(VERDICTS)
    return pd.DataFrame(
        {
            "id": [f"object{number}" for number in range(count)],
            "verdict": VERDICTS,
            "complexity": rng.uniform(0, 5, count),
            "graspability": rng.uniform(0, 0.02, count),
        }
    )


def test_there_are_as_many_objects_of_each_kind_none_twice(study, examined):
    """Of what networks found graspable; one that any of them fails at is a failure."""
    other = examined.assign(verdict="detector_succeeds").iloc[:2]
    found = study["further_objects"](
        [SimpleNamespace(examined=part) for part in (other, examined, other)]
    )
    assert list(found) == ["failures", "random", "hard"]
    failing = {"object0", "object1", "object2"}
    assert set(found["failures"]["id"]) == failing
    for objects in found.values():
        assert len(objects) == objects["id"].nunique() == 3
        assert set(objects["id"]) <= set(examined["id"][:11])
    assert not failing & set(found["hard"]["id"])


def test_the_most_similar_ones_are_nearest_if_none_is_wanted_twice(study):
    rng = np.random.default_rng(1)
    among = rng.uniform(size=(6, 2))
    wanted = among[[4, 1, 3]] + 1e-6
    assert study["most_similar"](wanted, among) == [4, 1, 3]
    twice = study["most_similar"](among[[2, 2]], among)
    others = np.linalg.norm(among - among[2], axis=1)
    assert twice == np.argsort(others)[:2].tolist()
    with pytest.raises(ValueError, match="3 objects are wanted, and there are 2"):
        study["most_similar"](wanted, among[:2])


def test_a_scale_does_not_matter_for_what_is_similar(study):
    rng = np.random.default_rng(2)
    wanted, among = rng.uniform(size=(4, 2)), rng.uniform(size=(9, 2))
    factors = np.array([1.0, 1000.0])
    found = study["most_similar"](wanted, among)
    assert study["most_similar"](wanted * factors, among * factors) == found


def packed(solid):
    return np.packbits(solid).tobytes()


def test_tested_objects_are_unlike_each_other_and_perhaps_like_a_training_object(study):
    rng = np.random.default_rng(3)
    known, first, second = rng.random((3, 1000)) < 0.3
    nearly = known.copy()
    nearly[np.flatnonzero(known)[:5]] = False
    again = first.copy()
    again[np.flatnonzero(~first)[:3]] = True
    rows = {"known": known, "nearly": nearly, "first": first, "again": again, "second": second}
    table = pd.DataFrame({"id": list(rows), "voxels": [packed(solid) for solid in rows.values()]})
    halves = [SimpleNamespace(table=part) for part in (table.iloc[:3], table.iloc[3:])]
    chosen = {"hard": pd.DataFrame({"voxels": [packed(known)]})}
    found = study["tested_objects"](halves, chosen)
    assert list(found.items()) == [("first", True), ("second", True), ("known", False)]
    by_hand = (known & first).sum() / (known | first).sum()
    assert sys.modules["failures"].overlap(packed(known), packed(first)) == pytest.approx(by_hand)


def test_work_that_was_cut_off_is_done_again_and_its_time_counts(study, tmp_path):
    calls = []

    def work():
        calls.append(1)
        sum(range(3_000_000))
        if len(calls) == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        study["once"](tmp_path / "a", work)
    first = (tmp_path / "a/cpu.txt").read_text()
    study["once"](tmp_path / "a", work)
    study["once"](tmp_path / "a", work)
    assert len(calls) == 2
    assert float((tmp_path / "a/cpu.txt").read_text()) >= float(first)


def test_rounds_and_failures_are_counted(tables):
    rows = pd.DataFrame(
        {"round": [0, 0, 0, 1], "n_objects": [2, 2, 2, 3], "success": [True, False, True, False]}
    )
    assert tables["share"](tables["by_round"](rows)) == pytest.approx(2 / 5)
    rows = pd.DataFrame(
        {"id": ["a", "a", "b"], "engine": ["x", "y", "x"], "n": [4, 4, 2], "detector": [1, 2, 2]}
    ).assign(is_new=[True, True, False])
    assert tables["share"](tables["by_failure"](rows)) == pytest.approx(1 / 2)
    assert tables["share"](tables["by_new_failure"](rows)) == pytest.approx(3 / 8)


def test_first_grasps_of_a_search_end_with_the_object_that_exceeds_them(tables, monkeypatch):
    """Where the second search, of so many grasps, ended too."""
    voxels = [packed(np.arange(64) // 8 == row) for row in range(4)]
    verdicts = ["failure", "failure", "detector_succeeds", "failure"]
    rows = pd.DataFrame({"attempts": [100, 1900, 1500, 80], "verdict": verdicts, "voxels": voxels})
    again = rows.assign(voxels=voxels[:1] * 4)
    atlases = iter([SimpleNamespace(examined=rows), SimpleNamespace(examined=again)])
    monkeypatch.setitem(
        tables["yields"].__globals__,
        "FailureAtlas",
        SimpleNamespace(load=lambda _: next(atlases)),
    )
    paths = [Path("a"), Path("b")]
    assert tables["yields"](paths) == (
        *(2, "6 (3, 3)", 3, 7160, "0.8"),
        *("4 (2, 2)", 2, 7000, "0.6"),
    )


def test_turns_of_the_hand_are_counted_where_one_of_them_holds():
    pytest.importorskip("torch")
    grasps = [pd.DataFrame({"yaws": yaws}) for yaws in ([[0, 1, 1], [0, 0, 0]], [], [[0, 1, 0]])]
    with names_of("curriculum_scores.py") as scores:
        assert scores["turns_that_hold"](grasps) == ("66.7", "1.50 of 3")


def counts(rng, rates, n=20):
    """Attempts at 30 objects with these rates."""
    return pd.DataFrame({"n": n, "won": rng.binomial(n, rates)}, index=range(len(rates)))


def test_differences_are_paired_over_networks(tables):
    """By hand."""
    rng = np.random.default_rng(4)
    networks, others = ([counts(rng, np.full(30, p)) for _ in range(3)] for p in (0.6, 0.4))
    first, second = (
        np.array([each["won"].sum() / each["n"].sum() for each in some])
        for some in (networks, others)
    )
    gains = first - second
    half = scipy.stats.t.ppf(0.975, 2) * gains.std(ddof=1) / np.sqrt(3)
    p = 2 * scipy.stats.t.sf(gains.mean() / (gains.std(ddof=1) / np.sqrt(3)), 2)
    said = tables["versus"](networks, others)
    low, high = 100 * (gains.mean() - half), 100 * (gains.mean() + half)
    assert said.startswith(f"{100 * gains.mean():.1f} ({low:.1f} to {high:.1f}), p = {p:.3f}; ")


def test_the_interval_for_other_objects_is_that_of_a_mean_over_objects(tables):
    """Where one network is compared with one, and objects differ in how much is gained."""
    rng = np.random.default_rng(5)
    rates = rng.uniform(0.2, 0.8, 30)
    one, other = counts(rng, rates, 1000), counts(rng, np.clip(rates - 0.1, 0, 1), 1000)
    low, high = tables["resampled"]([one], [other])
    gains = (one["won"] - other["won"]) / 1000
    half = 1.96 * gains.std() / np.sqrt(30)
    assert low == pytest.approx(gains.mean() - half, abs=0.01)
    assert high == pytest.approx(gains.mean() + half, abs=0.01)
    assert tables["resampled"]([one], [one]) == (0, 0)
