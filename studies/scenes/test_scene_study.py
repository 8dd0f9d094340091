"""The study of scenes: its configuration and its tables."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from partial_tables import fill_columns, write_rows
from scene_charts import cleared_by, learning_chart
from scene_plan import (
    condition_settings,
    networks_of,
    study_of,
    training_scenes,
    training_settings,
)
from write_scene_tables import (
    cleared,
    difference,
    draws,
    goals,
    interval,
    outcomes,
    rounds_of,
    scored,
    share_of,
    thirds,
)

from egad.errors import UserError
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.training import SCENE_SCORE

FILE = Path(__file__).with_name("study.yaml")


@pytest.fixture(scope="module")
def asked():
    return yaml.safe_load(FILE.read_text(encoding="utf-8"))


def test_networks_are_detectors_with_weights_that_the_study_makes(asked):
    study = study_of(asked)
    names = list(networks_of(study.plan))
    assert len(names) == 3 * 5 + 2
    assert set(study.detectors) <= set(study.settings.detectors)
    first = study.settings.detectors["evolved-1"]
    assert first.weights == "results/scene_study/networks/evolved/1/weights.safetensors"
    assert (first.detector, first.threshold) == ("vgn", 0.1)


def test_networks_of_a_set_differ_in_their_seed_and_sets_in_their_scenes(asked):
    study = study_of(asked)
    few, other = (training_settings(study, "evolved-100", seed) for seed in (0, 1))
    assert (few.seed, other.seed) == (0, 1)
    assert few.training.scenes == 100
    assert training_settings(study, "evolved", 0).training.scenes is None
    assert few.training.examples == 16000
    assert training_settings(study, "tuned-evolved", 0).training.examples == 4000
    assert study.plan.sets["tuned-evolved"].start == "weights/vgn_conv.pth"


def test_sets_have_as_many_training_scenes_as_they_are_trained_on(asked):
    counts = training_scenes(study_of(asked))
    assert counts["evolved"] == counts["ycb"] == 960  # of 1200, less a tenth twice
    assert (counts["evolved-100"], counts["evolved-300"]) == (100, 300)


def test_conditions_differ_in_cameras_and_rounds(asked):
    study = study_of(asked)
    six, side = (condition_settings(study, name).clutter for name in ("six", "side"))
    assert (six.rounds, side.rounds) == (40, 10)
    assert (six.protocol.cameras.views, side.protocol.cameras.views) == (6, 1)
    assert six.protocol.name == "egad"
    assert side.noises == six.noises == ("none", "dex")


def test_unknown_names_are_refused(asked):
    with pytest.raises(UserError, match="not defined: nowhere, nobody"):
        study_of(asked | {"tests": ["nowhere"], "references": ["nobody"]})


def rounds(shares, count=40, there=5, test="egad", noise="none"):
    """Rounds of each detector, with about the share that each clears."""
    rng = np.random.default_rng(0)
    luck = rng.normal(scale=0.05, size=count)  # of a round, for all detectors
    return pd.concat(
        [
            pd.DataFrame(
                {
                    "scene": "pile",
                    "noise": noise,
                    "round": range(count),
                    "cleared": rng.binomial(there, np.clip(share + luck, 0, 1)),
                    "there": there,
                    "test": test,
                    "cameras": "six",
                    "detector": f"{name}-{number}" if len(each) > 1 else name,
                    "name": name,
                }
            )
            for name, each in shares.items()
            for number, share in enumerate(each)
        ],
        ignore_index=True,
    )


GOOD = {"evolved": [0.86, 0.9, 0.88], "primitives": [0.8, 0.82, 0.81], "vgn": [0.5]}
ALL = GOOD | {f"tuned-{name}": GOOD[name] for name in ("evolved", "primitives")}


def test_shares_are_means_over_networks_of_what_each_clears():
    table = rounds(GOOD)
    by_hand = [
        rows["cleared"].sum() / (5 * 40)
        for _, rows in table[table["name"] == "evolved"].groupby("detector")
    ]
    assert len(by_hand) == 3
    assert share_of(table[table["name"] == "evolved"]) == pytest.approx(np.mean(by_hand))


def rows_of(text):
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines()[2:]]


def test_goals_are_met_by_a_lead_and_by_not_being_behind():
    shares = ALL | {"vgn-low": [0.6], "tuned-evolved": [0.66, 0.7, 0.68]}
    found = rows_of(goals(rounds(shares)))
    assert [row[:3] + row[4:] for row in found] == [
        ["egad, no noise", "evolved", "vgn-low", "yes"],  # the better of the two
        ["all", "evolved", "primitives", "yes"],
        ["egad, no noise", "tuned-evolved", "vgn-low", "no"],
        ["all", "tuned-evolved", "tuned-primitives", "no"],
    ]


def test_noise_counts_against_the_rival_alone():
    """With noise, ours is as good as it is bad without."""
    shares = ALL | {"vgn-low": [0.6]}
    clear = rounds(shares | {"evolved": [0.4, 0.4, 0.4]})
    found = rows_of(goals(pd.concat([clear, rounds(shares | {"evolved": [1.0] * 3}, noise="dex")])))
    assert float(found[0][3].split()[0]) == pytest.approx(-20, abs=4)
    assert float(found[1][3].split()[0]) == pytest.approx(70 - 81, abs=4)


def test_a_lead_must_be_certain():
    """On average it is 13 points, but one network of three is far behind."""
    table = rounds({name: [1] * len(each) for name, each in ALL.items()} | {"vgn-low": [1]})
    counts = {"evolved-1": 1, "vgn": 3, "vgn-low": 3}
    table["cleared"] = table["detector"].map(counts).fillna(5)
    table.loc[table["name"] == "primitives", "cleared"] = 3
    first, second, *_ = rows_of(goals(table))
    assert first[3].startswith("13.3 (-52.0 to 46.0")
    assert (first[4], second[4]) == ("no", "no")


def test_tests_that_count_together_are_more_certain_than_each():
    """But the chance of the networks stays, as they are the same in all."""
    certain, uncertain = [0.7] * 3, [0.5, 0.7, 0.9]
    for ours, least, most in ((certain, 0.4, 0.7), (uncertain, 0.85, 1.15)):
        tests = [rounds({"one": ours, "other": [0.6]}, test=name) for name in "abcd"]
        alone, together = (
            np.subtract(*difference(some, "one", "other")[1][::-1]) for some in (tests[:1], tests)
        )
        assert least < together / alone < most


def test_intervals_hold_the_truth_though_there_are_three_networks():
    """They are too wide: the chance of rounds is in the spread of networks, and is drawn again."""
    covered, widths = [], []
    for seed in range(75):
        rng = np.random.default_rng(seed)
        table = rounds({"one": rng.normal(0.8, 0.02, 3), "other": rng.normal(0.7, 0.02, 3)})
        low, high = np.quantile(draws(table, "one", "other"), [0.025, 0.975])
        covered.append(low < 0.1 < high)
        widths.append(high - low)
    assert np.mean(covered) > 0.93
    assert np.mean(widths) < 0.25


def test_a_scene_with_both_kinds_of_noise_is_one_scene():
    """If noise changes nothing, it makes nothing more certain."""
    table = rounds({"one": [0.7, 0.7]})
    both = pd.concat([table, table.assign(noise="dex")])
    assert interval(both, "one") == interval(table, "one")


def test_rounds_of_both_kinds_of_noise_count_apart(tmp_path):
    """They begin with the same scene; one of two objects is cleared, and then both."""
    rows = [
        {"scene": "pile", "noise": noise, "round": 0, "n_objects": 2, "attempt": number}
        | {"success": success, "outcome": "success" if success else "missed"}
        for noise, attempts in (("none", (True, False)), ("dex", (True, True)))
        for number, success in enumerate(attempts)
    ]
    path = tmp_path / "egad/six/evolved-2.parquet"
    path.parent.mkdir(parents=True)
    write_rows(CLUTTER, rows, path)
    table = parquet.read(path, CLUTTER)
    found = rounds_of(path, table, {"evolved-2": "evolved"})
    assert found.set_index("noise")["cleared"].to_dict() == {"none": 1, "dex": 2}
    assert share_of(found) == 3 / 4
    assert found[["test", "cameras", "name"]].iloc[0].tolist() == ["egad", "six", "evolved"]
    assert rounds_of(path, table, {})["name"].iloc[0] == "evolved-2"


def test_every_condition_has_a_column():
    table = pd.concat([rounds(GOOD), rounds(GOOD, noise="dex")])
    lines = cleared(table).splitlines()
    assert lines[0] == "| % | egad, none | egad, dex |"
    assert [line.split("|")[1].strip() for line in lines[2:]] == list(GOOD)


def test_outcomes_and_thirds_are_shares(tmp_path):
    rows = [
        {"scene": "pile", "round": n, "n_objects": 1, "present": f"o{n}", "id": f"o{n}"}
        | {"success": n < 2, "outcome": "success" if n < 2 else "missed"}
        for n in range(3)
    ]
    attempts = {tmp_path / "egad/six/vgn.parquet": fill_columns(CLUTTER, rows)}
    measures = {"complexity": [1.0, 2.0, 3.0], "graspability": [1.0, 2.0, 3.0]}
    objects = {"egad": pd.DataFrame({"id": ["o0", "o1", "o2"], **measures})}
    assert outcomes(attempts, {}).splitlines()[2] == "| vgn | 33 | 67 |"
    assert thirds(attempts, {}, objects).splitlines()[2] == (
        "| egad | vgn | 100 | 100 | 0 | 0 | 100 | 100 |"
    )


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"references": ["labels"]}, "the goals compare these, too: vgn, vgn-low"),
        ({"cameras": {"one": {"rounds": 1}}}, "the goals are about the cameras `six`"),
    ],
)
def test_what_the_goals_need_must_be_there(asked, changes, words):
    with pytest.raises(UserError, match=words):
        study_of(asked | changes)


def test_tested_objects_must_be_held_out(asked):
    egad = asked["egad"] | {"scenes": {"scenes": 5, "hold_out": False}}
    with pytest.raises(UserError, match="networks would be trained on the tests"):
        study_of(asked | {"egad": egad})


def test_scores_name_the_network(tmp_path):
    path = tmp_path / "evolved/1/score.parquet"
    path.parent.mkdir(parents=True)
    numbers = dict(zip(("", "_ci_low", "_ci_high"), (0.5, 0.4, 0.6), strict=True))
    row = {f"average_precision{end}": value for end, value in numbers.items()}
    row |= {f"angle_error{end}": 60 * value for end, value in numbers.items()}
    write_rows(SCENE_SCORE, [row | {"n_positive": 1, "n_grasps": 4}], path)
    assert scored([path]).splitlines()[2] == (
        "| evolved-1 | 0.50 (0.40 to 0.60) | 0.25 | 30.0 (24.0 to 36.0) |"
    )


def test_the_chart_has_a_line_over_scenes_and_one_of_each_other_detector():
    table = rounds(GOOD | {"evolved-100": [0.4]} | {"vgn-low": [0.6]})
    found = cleared_by(table).set_index("detector")["share"]
    own = table[table["detector"] == "evolved-1"]
    assert found["evolved-1"] == pytest.approx(own["cleared"].sum() / own["there"].sum())
    drawn = learning_chart(
        table, {"evolved": 640, "primitives": 640, "evolved-100": 100}, "evolved"
    )
    for words in ("evolved", "primitives", "vgn", "vgn-low", "objects cleared", "training scenes"):
        assert f">{words}</text>" in drawn
    assert ">evolved-100</text>" not in drawn
