"""The study of scenes: its configuration and its tables."""

from pathlib import Path

import pandas as pd
import pytest
import scipy.stats
import yaml
from partial_tables import write_rows
from scene_plan import condition_settings, networks_of, study_of, training_settings
from write_scene_tables import cleared, goals, scored, shares_of

from egad.errors import UserError
from egad.tables.clutter import CLUTTER
from egad.tables.training import SCENE_SCORE

FILE = Path(__file__).parents[2] / "experiments/scene_study/study.yaml"
TESTS = ("egad", "primitives")


@pytest.fixture(scope="module")
def asked():
    return yaml.safe_load(FILE.read_text(encoding="utf-8"))


def test_networks_are_detectors_with_weights_that_the_study_makes(asked):
    study = study_of(asked)
    names = list(networks_of(study.plan))
    assert len(names) == 3 * 3 + 2
    assert set(study.detectors) <= set(study.settings.detectors)
    first = study.settings.detectors["evolved-1"]
    assert first.weights == "results/scene_study/networks/evolved/1/weights.safetensors"
    assert (first.detector, first.threshold) == ("vgn", 0.5)


def test_networks_of_a_set_differ_in_their_seed_and_sets_in_their_scenes(asked):
    study = study_of(asked)
    few, other = (training_settings(study, "evolved-100", seed) for seed in (0, 1))
    assert (few.seed, other.seed) == (0, 1)
    assert few.training_scenes.scenes == 100
    assert training_settings(study, "evolved", 0).training_scenes.scenes is None


def test_conditions_differ_in_cameras_and_rounds(asked):
    study = study_of(asked)
    six, side = (condition_settings(study, name).clutter for name in ("six", "side"))
    assert (six.rounds, side.rounds) == (20, 10)
    assert (six.protocol.cameras.views, side.protocol.cameras.views) == (6, 1)
    assert six.protocol.name == "egad"
    assert side.noises == six.noises == ("none", "dex")


def test_unknown_names_are_refused(asked):
    with pytest.raises(UserError, match="not defined: nowhere, nobody"):
        study_of(asked | {"tests": ["nowhere"], "references": ["nobody"]})


def shares(values):
    rows = [
        {"scene": "pile", "noise": "all", "cameras": "six", "test": test}
        | {"name": name, "cleared": share}
        for test in TESTS
        for name, each in values.items()
        for share in each
    ]
    return pd.DataFrame(rows)


def test_goals_are_tested_against_published_vgn_with_a_margin_and_against_primitives():
    values = {
        "evolved": [0.8, 0.84, 0.79],
        "primitives": [0.7, 0.76, 0.71],
        "vgn": [0.5],
        "vgn-half": [0.6],
    }
    lines = goals(shares(values)).splitlines()[2:]
    assert len(lines) == 4
    first, second = ([cell.strip() for cell in line.split("|")[1:-1]] for line in lines[:2])
    assert first[:4] == ["egad", "VGN + 10", "81 %", "70 %"]  # of the better of the two
    assert second[:4] == ["egad", "primitives", "81 %", "72 %"]
    one = scipy.stats.ttest_1samp(values["evolved"], 0.7)
    two = scipy.stats.ttest_ind(values["evolved"], values["primitives"], equal_var=False)
    smaller, larger = sorted([one.pvalue, two.pvalue])
    # Both tests come twice: Holm multiplies the two smallest by 4 and by 3
    expected = {smaller: 4 * smaller, larger: max(4 * smaller, 2 * larger)}
    assert float(first[5]) == pytest.approx(expected[one.pvalue], abs=6e-4)
    assert float(second[5]) == pytest.approx(expected[two.pvalue], abs=6e-4)
    low, high = one.confidence_interval()
    assert first[4] == f"11.0 ({100 * (low - 0.7):.1f} to {100 * (high - 0.7):.1f})"


def test_shares_are_of_both_kinds_of_noise_and_of_all(tmp_path):
    """Round 0 clears one of two objects, round 1 none of three, with the other noise."""
    rows = [
        {"scene": "pile", "noise": "none", "round": 0, "n_objects": 2, "attempt": 0}
        | {"success": True, "outcome": "success"},
        {"scene": "pile", "noise": "none", "round": 0, "n_objects": 2, "attempt": 1}
        | {"success": False, "outcome": "missed"},
        {"scene": "pile", "noise": "dex", "round": 1, "n_objects": 3, "attempt": 0}
        | {"success": False, "outcome": "missed"},
    ]
    path = tmp_path / "egad/six/evolved-2.parquet"
    path.parent.mkdir(parents=True)
    write_rows(CLUTTER, rows, path)
    found = shares_of(path).set_index("noise")
    assert found["cleared"].to_dict() == pytest.approx({"none": 0.5, "dex": 0, "all": 0.2})
    assert set(found["name"]) == {"evolved"}
    assert set(found["test"]) == {"egad"}
    assert set(found["cameras"]) == {"six"}


def test_means_are_over_the_networks_of_a_set():
    table = pd.concat(
        [
            shares({"evolved": [0.5, 0.7], "vgn": [0.4]}).assign(noise="dex"),
            shares({"evolved": [0.1], "vgn": [0.1]}),
        ]
    )
    lines = cleared(table).splitlines()
    assert lines[0] == "| detector | egad, six, pile, dex | primitives, six, pile, dex |"
    assert lines[2:] == ["| evolved | 60 | 60 |", "| vgn | 40 | 40 |"]


def test_scores_name_the_network(tmp_path):
    path = tmp_path / "evolved/1/score.parquet"
    path.parent.mkdir(parents=True)
    numbers = dict(zip(("", "_ci_low", "_ci_high"), (0.5, 0.4, 0.6), strict=True))
    row = {f"average_precision{end}": value for end, value in numbers.items()}
    write_rows(SCENE_SCORE, [row | {"n_positive": 1, "n_grasps": 4}], path)
    assert scored([path]).splitlines()[2] == "| evolved-1 | 0.50 (0.40 to 0.60) | 0.25 |"
