"""Hands compared at boxes and plates, whose results are known beforehand."""

import numpy as np
import pytest
import trimesh

import egad
from egad.bench.hands import compare_hands
from egad.bench.hands.attempts import SETTLED
from egad.errors import UserError

BOX = trimesh.creation.box((0.04, 0.05, 0.04))
CUBE = trimesh.creation.box((0.09, 0.09, 0.09))  # wider than jaws open
EASY = {"drops": 2, "search_drops": 2, "errors": "none", "noise": "none"}


@pytest.fixture(scope="module")
def found():
    hands = {"panda": "panda", "cup": "cup_30mm"}
    return compare_hands(hands, {"box": BOX, "cube": CUBE}, **EASY)


def results(found, hand, label, grasper):
    rows = found.attempts(hand, grasper)
    return rows[rows["label"] == label]


def test_what_a_hand_can_hold_it_holds_and_what_it_cannot_is_never_held(found):
    assert results(found, "panda", "box", "best")["success"].tolist() == [True, True]
    assert results(found, "panda", "box", "detector")["success"].tolist() == [True, True]
    assert results(found, "cup", "box", "best")["success"].tolist() == [True, True]
    assert found.never_held("panda")["label"].unique().tolist() == ["cube"]
    assert set(results(found, "panda", "cube", "detector")["cause"]) == {"none_reachable"}
    assert "box" not in set(found.never_held("cup")["label"])


def test_all_hands_meet_an_object_in_the_same_poses(found):
    rest = [name for name in found.table if name.startswith("rest_")]
    poses = found.table.drop_duplicates(["label", "drop", *rest])
    assert poses.groupby("label")["drop"].apply(list).to_dict() == {
        "box": [0, 1, 2, 3],
        "cube": [0, 1, 2, 3],
    }


def test_naive_grasps_touch_the_same_points_whatever_the_hand(found):
    """The fingertip of jaws is beyond the point by some depth, the ring of a cup is on it."""
    jaws, cup = (
        np.stack(list(results(found, name, "box", "naive")["pose"])).reshape(-1, 3, 4)
        for name in ("panda", "cup")
    )
    assert jaws[:, :, :3] == pytest.approx(cup[:, :, :3])
    away = jaws[:, :, 3] - cup[:, :, 3]
    beside = np.linalg.norm(np.cross(away, cup[:, :, 2]), axis=1)
    assert beside == pytest.approx(np.zeros(len(beside)), abs=1e-12)


def test_drops_to_search_on_do_not_count(found):
    by_grasper = found.table.groupby("grasper")["drop"].unique()
    assert set(by_grasper["search"]) == {0, 1}
    assert set(by_grasper["best"]) == set(by_grasper["naive"]) == {2, 3}


def test_sizes_are_those_of_the_meshes(found):
    sides = found.table.drop_duplicates("label").set_index("label")
    assert sides.loc["box", ["smallest_side", "longest_side"]].tolist() == pytest.approx(
        [0.04, 0.05], rel=1e-3
    )


def test_the_table_does_not_depend_on_processes_and_hands_beside_it(found):
    alone = compare_hands(["panda"], {"box": BOX, "cube": CUBE}, **EASY, jobs=2)
    same = found.table[found.table["hand"] == "panda"].reset_index(drop=True)
    assert alone.table.equals(same)


def test_a_search_ends_once_its_grasps_hold():
    whole = compare_hands(["panda"], {"box": BOX}, **EASY | {"drops": 1, "search_drops": 9})
    assert (whole.table["grasper"] == "search").sum() == SETTLED


@pytest.mark.parametrize(
    ("hands", "objects", "more", "message"),
    [
        (
            {"wide": "panda", "tiny": egad.Gripper(opening=0.02)},
            {"box": BOX, "bar": CUBE},
            {},
            r"hand tiny opens 20 mm, less than the smallest object, box, is thick \(40 mm\)",
        ),
        (["panda", "cup_30mm"], {"box": BOX}, {"detector": "suction-depth"}, "the hand panda: .*"),
        (
            ["panda", "cup_30mm"],
            {"box": BOX},
            {"detector": "antipodal-cloud"},
            "the hand cup_30mm: the detector antipodal-cloud is for jaws",
        ),
        (["panda"], {"box": BOX}, {"detector": "labels"}, "detector .*labels"),
        (["panda", "panda"], {"box": BOX}, {}, "panda is given twice"),
        ([egad.Gripper(opening=0.05)], {"box": BOX}, {}, "has no name"),
        ([], {"box": BOX}, {}, "no hands"),
        (["panda"], {"box": BOX}, {"drops": 0}, "drops is 0"),
        (["panda"], {"box": BOX}, {"errors": "many"}, "errors is 'many'"),
        (["hook"], {"box": BOX}, {}, "gripper .*hook"),
    ],
)
def test_what_cannot_be_compared_is_named(hands, objects, more, message):
    with pytest.raises(UserError, match=message):
        compare_hands(hands, objects, **more)


def test_an_object_that_cannot_be_simulated_is_left_out(caplog):
    opened = BOX.copy()
    opened.update_faces(np.arange(len(BOX.faces)) > 0)
    with pytest.raises(UserError, match="none of the objects can be simulated"):
        compare_hands(["panda"], {"open": opened}, **EASY)
    assert "open is left out" in caplog.text
