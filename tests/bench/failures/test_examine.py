"""Whether an object is a failure, of objects and detectors of which that is known."""

import pandas as pd
import pytest
import trimesh
from failing import CUBE, beside, both, nothing, parameters

import egad
from egad.bench.failures import Examination, ObjectVerdict
from egad.bench.failures.evidence import explanation, failed_drops, pairs_of
from egad.detectors.antipodal import antipodal_depth
from egad.evalset import PrintCheck
from egad.tables.outcomes import Outcome

SETTINGS = parameters()


def examined(mesh, detect, settings=SETTINGS):
    return Examination(mesh, "object", detect, settings).run()


@pytest.fixture(scope="module")
def failure():
    return examined(CUBE, beside)


def test_a_cube_is_a_failure_of_a_detector_that_misses_it(failure):
    assert failure.verdict == ObjectVerdict.FAILURE
    assert failure.objective == 0.6  # 3 of 3 drops, shrunk
    for engine in SETTINGS.failures.engines:
        pairs = failure.pairs(engine)
        assert [pair.detector for pair in pairs] == [False] * len(pairs)
        assert all(pair.reference for pair in pairs)


def test_every_attempt_is_a_row(failure):
    table = failure.attempts
    assert set(table["purpose"]) == {"screen", "choose", "confirm"}
    fresh = table[table["purpose"] == "confirm"]
    assert (fresh.groupby(["engine", "drop"])["who"].nunique() == 2).all()
    by_detector = table[table["who"] == "detector"]
    assert set(by_detector["outcome"]) == {Outcome.MISSED}
    # Both begin where the object lies, and fresh drops are those of no other purpose.
    places = table.groupby(["engine", "purpose", "drop"])[["rest_x", "rest_y", "rest_qw"]]
    assert (places.nunique() == 1).all(axis=None)
    starts = table.drop_duplicates(["engine", "purpose", "drop"])
    assert not starts.duplicated(["engine", "rest_x", "rest_y"]).any()


def test_it_is_the_same_again(failure):
    again = examined(CUBE, beside).attempts
    assert again.equals(failure.attempts)


def test_an_object_that_the_detector_holds_costs_few_attempts():
    found = examined(CUBE, antipodal_depth)
    assert found.verdict == ObjectVerdict.DETECTOR_SUCCEEDS
    assert len(found.attempts) == 1
    assert found.objective == 0


def test_what_nobody_can_grasp_is_no_failure():
    found = examined(trimesh.creation.box((0.2, 0.2, 0.1)), beside)
    assert found.verdict == ObjectVerdict.NOT_GRASPABLE
    assert found.objective == 0
    assert not found.attempts.loc[found.attempts["who"] == "reference", "success"].any()


def test_what_cannot_be_printed_is_no_failure():
    thin = trimesh.creation.box((0.05, 0.05, 0.0008))
    post = trimesh.creation.box((0.03, 0.03, 0.04))
    post.apply_translation((0, 0, 0.02))
    plate = trimesh.boolean.union([thin, post], engine="manifold")
    settings = SETTINGS.model_copy(update={"print_check": PrintCheck()})
    found = examined(plate, beside, settings)
    assert found.verdict == ObjectVerdict.NOT_PRINTABLE
    assert "thinner than 1.2 mm" in found.reason


def test_what_bounds_no_solid_is_told():
    found = examined(CUBE.submesh([[0, 1, 2, 3]], append=True), beside)
    assert found.verdict == ObjectVerdict.NOT_SIMULATED
    assert found.reason
    assert not len(found.attempts)


def test_a_better_reference_than_the_detector_is_not_enough():
    strict = parameters(least_reference=0.99, confirm=5)
    assert examined(CUBE, beside, strict).verdict == ObjectVerdict.NOT_CONFIRMED


@pytest.mark.parametrize(
    ("detect", "parts"),
    [
        (nothing, {"n_nothing": 3, "n_not_chosen": 0, "n_none_good": 0}),
        (beside, {"n_nothing": 0, "n_not_chosen": 0, "n_none_good": 3}),
        (both, {"n_nothing": 0, "n_not_chosen": 3, "n_none_good": 0}),
    ],
)
def test_why_a_detector_fails(detect, parts):
    found = examined(CUBE, detect)
    assert found.verdict == ObjectVerdict.FAILURE
    engine, most = SETTINGS.failures.engines[0], SETTINGS.failures.explain
    further = Examination(CUBE, "object", detect, SETTINGS).explain(found.attempts)
    assert set(further["purpose"]) <= {"explain"}
    whole = pd.concat([found.attempts, further])
    assert explanation(whole, engine, most) == {"n_explained": 3} | parts
    assert len(failed_drops(whole, engine)) == 3
    assert pairs_of(whole, engine) == found.pairs(engine)


def test_a_suction_cup_is_examined_in_the_same_way():
    settings = parameters().model_copy(update={"gripper": egad.gripper("cup_15mm")})
    flat = trimesh.creation.box((0.06, 0.06, 0.05))
    found = examined(flat, nothing, settings)
    assert found.verdict == ObjectVerdict.FAILURE
