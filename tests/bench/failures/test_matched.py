"""Failures matched with similar objects that the detector grasps."""

from itertools import permutations

import numpy as np
import pandas as pd
import pytest
from bars import NONE, mesh_of, name_of, settings, thick_only
from partial_tables import fill_columns

import egad
from egad.bench.failures import Examination, FailureAtlas, MatchedSet, match_failures
from egad.bench.failures.evidence import pairs_of
from egad.bench.failures.matching import assign, spread
from egad.detectors import opened
from egad.detectors.failures import OnlyFailuresError
from egad.errors import RejectedError, UserError
from egad.evolution import Shape
from egad.measures import cell_of
from egad.objects import dataset_of
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE

POSE = ["rest_x", "rest_qw", "pose", "width", "score", "outcome"]


def test_failures_are_spread_over_the_map_and_the_worst_one_is_first():
    cells = np.array([[0, 0], [0, 1], [9, 9], [9, 0], [0, 9]], dtype=float)
    assert spread(cells, np.array([0.5, 0.9, 0.6, 0.7, 0.7])) == [1, 2, 3, 4, 0]
    assert spread(np.zeros((3, 2)), np.array([0.5, 0.9, 0.9])) == [1, 2, 0]


@pytest.mark.parametrize("seed", range(20))
def test_partners_are_those_of_the_largest_sum_among_all_ways(seed):
    rng = np.random.default_rng(seed)
    similarity, allowed = rng.random((3, 4)), rng.random((3, 4)) < 0.6
    ways = [
        [each if allowed[row, each] else -1 for row, each in enumerate(way)]
        for way in permutations(range(4), 3)
    ]

    def worth(way):
        used = [(row, each) for row, each in enumerate(way) if each >= 0]
        return len(used), sum(similarity[each] for each in used)

    partners = assign(np.where(allowed, similarity, np.nan), allowed)
    assert worth(partners) == pytest.approx(max(map(worth, ways)))
    assert all(each < 0 or allowed[row, each] for row, each in enumerate(partners))


@pytest.fixture(scope="module")
def thin(failing, tmp_path_factory):
    """The attempts at a failure, as a saved atlas has them."""
    folder = tmp_path_factory.mktemp("atlas")
    failing.save(folder)
    attempts = FailureAtlas.load(folder).attempts
    return attempts[attempts["id"] == name_of("thin")].reset_index(drop=True)


def again(bar, purpose, count, before, least=0, detect=thick_only):
    with opened(detect, 60.0) as asked:
        examination = Examination(mesh_of(bar), name_of(bar), asked, settings())
        return examination.paired(purpose, count, before, least)


def test_a_reference_made_of_attempts_gives_the_grasps_of_the_first_one(thin):
    """On the drops that confirmed the failure, to the last digit."""
    first = thin[thin["purpose"] == "confirm"].reset_index(drop=True)
    found = again("thin", "confirm", len(pairs_of(first, "mujoco")), thin)
    assert len(first) >= 10
    pd.testing.assert_frame_equal(found[POSE].map(tuple_of), first[POSE].map(tuple_of))


def tuple_of(value):
    return tuple(value) if isinstance(value, list | np.ndarray) else value


def test_a_choice_that_was_cut_short_is_completed_as_if_it_had_not_been(thin):
    is_late = (thin["purpose"] == "choose") & (thin["drop"] >= 2)
    cut = thin[~is_late & (thin["purpose"] != "confirm")]
    found = again("thin", "matched", 2, cut)
    made = found[found["purpose"] == "choose"].reset_index(drop=True)
    expected = thin[is_late].reset_index(drop=True)
    pd.testing.assert_frame_equal(made[POSE].map(tuple_of), expected[POSE].map(tuple_of))


def test_pairs_are_as_many_as_asked_for_from_the_same_poses_on_drops_of_their_own(thin):
    found = again("thin", "matched", 3, thin)
    assert pairs_of(found, "mujoco", "matched") == [(True, False)] * 3
    rests = found.groupby("who")["rest_x"].apply(list)
    assert rests["detector"] == rests["reference"]
    assert not set(found["rest_x"]) & set(thin["rest_x"])


def test_an_object_that_never_comes_to_rest_is_rejected(thin, monkeypatch):
    monkeypatch.setattr("egad.bench.trial_runner.TrialRunner.drop", lambda *_: None)
    with pytest.raises(RejectedError, match="it comes to rest in 0 of 6 drops"):
        again("thin", "matched", 3, thin)


def test_every_failure_has_a_partner_that_is_grasped(matched):
    rows = matched.table.set_index("label")
    assert rows.index.tolist() == ["A0", "A1", "B0", "B1"]
    assert rows["id"]["A0"] == name_of("thin")
    assert rows["id"]["A1"] == name_of("flat")
    assert set(rows["id"][["B0", "B1"]]) == {name_of("thick"), name_of("broad")}
    assert rows["is_failure"].tolist() == [True, True, False, False]
    assert (rows["n_pairs_mujoco"] == 5).all()
    assert (rows["n_pairs_pybullet"] == 0).all()
    assert rows["detector_successes_mujoco"].tolist() == [0, 0, 5, 5]
    assert rows["reference_successes_mujoco"].tolist() == [5, 5, 5, 5]
    assert "detector 0 % at failures and 100 % at their partners" in repr(matched)


def test_the_similarity_of_a_pair_is_that_of_its_meshes(matched):
    rows, objects = matched.table.set_index("label"), matched.objects
    for first, second in (("A0", "B0"), ("A1", "B1")):
        meshes = [objects[rows["id"][label]].mesh for label in (first, second)]
        expected = egad.similarity_matrix(meshes)[0, 1]
        assert rows["similarity"][first] == rows["similarity"][second] == pytest.approx(expected)


def test_an_object_that_the_detector_does_not_grasp_again_is_replaced(failing, matched):
    """It is the most similar one; it was found to be grasped by chance."""
    meshes = [mesh_of(bar) for bar in ("thin", "liar", "thick", "broad")]
    assert egad.similarity_matrix(meshes)[0].argsort()[-2] == 1
    assert matched.replaced == {"the detector succeeds in less than 80 %": 1}
    tried = matched.attempts.groupby("id")["purpose"].unique().map(set)
    assert tried[name_of("liar")] == {"qualify"}
    assert tried[name_of("thin")] == {"matched"}
    assert tried[name_of("thick")] == {"choose", "qualify", "matched"}
    assert not failing.attempts["purpose"].isin(["qualify", "matched"]).any()


def without(atlas, *bars):
    """The atlas without some of the objects that the detector succeeds at."""
    gone = atlas.examined["id"].isin(list(map(name_of, bars)))
    return FailureAtlas(
        atlas.table, atlas.examined[~gone], atlas.attempts, atlas.shape, atlas.settings
    )


def test_a_failure_without_a_partner_is_left_out(failing):
    found = match_failures(without(failing, "liar", "broad"), thick_only, attempts=1, objects=NONE)
    assert found.table["id"].tolist() == [name_of("thin"), name_of("thick")]
    assert (len(found), found.unmatched) == (1, 1)


def test_objects_that_the_search_did_not_try_may_become_partners(failing):
    """They are put into cells by their measures."""
    space = settings().breeding.space
    values = [(c, g) for c in np.linspace(0, 4, 80) for g in np.linspace(0, 0.006, 80)]
    near = next(pair for pair in values if cell_of(*pair, space) == (5, 5))
    row = parquet.records(failing.examined[failing.examined["id"] == name_of("broad")])[0]
    row |= dict(zip(("complexity", "graspability"), near, strict=True)) | {"epoch": 0}
    objects = dataset_of(
        fill_columns(ARCHIVE, [{k: row[k] for k in ARCHIVE.names if k in row}]), Shape()
    )
    few = without(failing, "thick", "broad", "liar")
    few.attempts = few.attempts[few.attempts["id"] != name_of("broad")]
    found = match_failures(few, thick_only, attempts=1, objects=objects)
    assert found.table["id"].tolist()[1:] == [name_of("broad")]
    assert found.table["detector_successes_mujoco"].tolist() == [0, 1]


def test_a_partner_may_lie_farther_away_if_that_is_allowed(failing):
    """Of the flat failure in column 8, thick in column 3 is the only partner that is left."""
    few = without(failing, "liar", "broad", "far")
    few.table = few.table[few.table["id"] == name_of("flat")]
    with pytest.raises(UserError, match="none of 1 failures has an object within 2 cells"):
        match_failures(few, thick_only, attempts=1, objects=NONE)
    found = match_failures(few, thick_only, attempts=1, within=5, objects=NONE)
    assert found.table["id"].tolist() == [name_of("flat"), name_of("thick")]


def test_a_detector_that_only_crashes_is_told_with_its_error(failing):
    def broken(*_):
        raise ZeroDivisionError("no luck")

    with pytest.raises(OnlyFailuresError, match=r"(?s)failed in all \d+ attempts.*no luck"):
        match_failures(failing, broken, attempts=5, objects=NONE)


def test_objects_whose_voxels_are_other_meshes_are_refused(failing):
    objects = dataset_of(egad.load().archive[:1], Shape(smoothing_iterations=1))
    with pytest.raises(UserError, match="different settings of shapes, which turn voxels"):
        match_failures(failing, thick_only, objects=objects)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"pairs": 11}, "pairs is 11; allowed: 1 to 10"),
        ({"attempts": 0}, "attempts is 0"),
        ({"succeeds": 0}, "succeeds is 0; allowed: a rate above 0, at most 1"),
    ],
)
def test_wrong_arguments_are_refused(failing, arguments, words):
    with pytest.raises(UserError, match=words):
        match_failures(failing, thick_only, **arguments)


def test_a_set_is_read_as_it_was_saved(matched, tmp_path):
    matched.save(tmp_path)
    found = MatchedSet.load(tmp_path)
    assert repr(found) == repr(matched)
    assert found.table["id"].tolist() == matched.table["id"].tolist()
    assert (found.replaced, found.unmatched) == (matched.replaced, matched.unmatched)
    assert found.rules == matched.rules == (2, 0.8)
    assert found.attempts["pose"].map(len).tolist() == matched.attempts["pose"].map(len).tolist()
    assert set(egad.load(tmp_path / "pairs.parquet").table["id"]) == set(matched.table["id"])
