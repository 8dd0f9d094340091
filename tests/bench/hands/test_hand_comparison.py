"""What a comparison of hands says, counted by hand."""

import pytest
from hand_cards import LABELS, card

from egad.bench.hands import HandComparison
from egad.errors import UserError


def test_rates_causes_and_objects_never_held_are_those_of_the_table():
    found = card()
    assert {name: each.successes for name, each in found.rates().items()} == {
        "yumi": 8,
        "panda": 14,
    }
    assert found.rates("naive")["panda"].value == 0
    causes = found.causes()
    assert causes.loc["panda"].to_dict() | {"held": 7, "swung": 7, "palm": 1, "finger": 1} == (
        causes.loc["panda"].to_dict()
    )
    assert causes.loc["yumi", ["held", "missed"]].tolist() == [8, 8]
    assert causes.loc["panda"].sum() == 16
    assert found.never_held("panda")["label"].unique().tolist() == ["B3"]
    assert found.never_held("yumi").empty


def test_differences_are_over_pairs_of_the_same_drop():
    found = card().compare("panda", "yumi")
    assert (found.objects, found.attempts, found.alike) == (8, 16, 16)
    assert found.difference == pytest.approx(6 / 16)
    assert (found.only_first, found.only_second) == (7, 1)
    assert found.interval[0] < 6 / 16 < found.interval[1]


def test_ranks_are_ties_unless_intervals_part():
    assert {name: str(each) for name, each in card(lost=()).ranks().items()} == {
        "yumi": "2",
        "panda": "1",
    }
    assert set(map(str, card(LABELS[:4]).ranks().values())) == {"1\N{EN DASH}2"}


def test_a_sentence_says_which_hand_is_better_or_that_none_is():
    best, detector, naive = card(lost=()).conclusions()
    assert best.startswith("Best grasps: panda is better than yumi by 50.0 percentage points")
    assert detector.startswith("Detector: panda is better than yumi by 50.0")
    assert naive.startswith("Naive grasps: panda vs yumi: no difference is shown")
    worse = card(lost=LABELS).conclusions()[0]
    assert "yumi is better than panda by 50.0 percentage points" in worse


def test_what_was_saved_is_read_back(tmp_path):
    saved = card()
    saved.save(tmp_path / "card.parquet")
    read = HandComparison.load(tmp_path / "card.parquet")
    assert read.conclusions() == saved.conclusions()
    assert (read.hands, read.settings, read.rule) == (saved.hands, saved.settings, saved.rule)
    assert read.detectors == saved.detectors


def test_a_hand_or_grasper_that_is_not_there_is_named():
    with pytest.raises(UserError, match=r"hand .*robot"):
        card().attempts("robot")
    with pytest.raises(UserError, match=r"grasper .*luck"):
        card().attempts("panda", "luck")


def test_success_rates_are_drawn():
    picture = card().plot().svg
    assert "yumi" in picture
    assert "best grasps" in picture
