"""A search for failures ends in the same tables however it is cut, spread and shown."""

import logging
import re

import pandas as pd
import pytest
from failure_searches import Aside, coarse_objects, failing, settings_of

from egad.bench.failures import FailureAtlas, finding, search, search_failures
from egad.bench.failures.store import Store
from egad.detectors.failures import OnlyFailuresError
from egad.errors import UserError

ONLY_FAILS = r"all \d+ attempts of the first 3 objects$"


@pytest.fixture(scope="module")
def objects():
    """A few of the coarse ones."""
    return coarse_objects().archive.iloc[:400:10].reset_index(drop=True)


@pytest.fixture(autouse=True)
def _small_steps(monkeypatch):
    monkeypatch.setattr(search, "LITTER", 1)
    monkeypatch.setattr(finding, "WRITING", 0.0)


@pytest.fixture(scope="module")
def whole(objects):
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(search, "LITTER", 1)
        return search_failures(objects, Aside(), settings_of())


def asked_in(found):
    """How often the detector was asked in a search, without what explains the failures."""
    mine = found.attempts[found.attempts["who"] == "detector"]
    return int((mine["purpose"] != "explain").sum())


def assert_same(one, other):
    for name in ("table", "examined", "attempts"):
        pd.testing.assert_frame_equal(getattr(one, name), getattr(other, name), check_dtype=False)


def test_a_search_that_is_cut_off_goes_on_to_the_same_tables(whole, objects, tmp_path):
    assert len(whole.examined) >= 5
    assert whole.examined["shard"].nunique() == 2
    assert "child" in set(whole.examined["source"])
    with pytest.raises(KeyboardInterrupt):
        search_failures(objects, Aside(last=7), settings_of(), folder=tmp_path)
    kept = Store(tmp_path, objects, Aside(), settings_of()).read(0)
    assert 0 < len(kept.examined) < len(whole.examined)
    again = Aside()
    assert_same(search_failures(objects, again, settings_of(), folder=tmp_path), whole)
    explained = whole.table["n_explained"].sum()
    assert again.asked == asked_in(whole) - asked_in(kept) + explained
    assert_same(FailureAtlas.load(tmp_path), whole)
    done = Aside()
    assert_same(search_failures(objects, done, settings_of(), folder=tmp_path), whole)
    assert done.asked == explained


def test_a_search_is_saved_in_a_folder_or_beside_a_file(whole, tmp_path):
    for place in (tmp_path / "atlas", tmp_path / "G" / "own.parquet"):
        whole.save(place)
        assert_same(FailureAtlas.load(place), whole)
    names = {path.name for path in (tmp_path / "G").iterdir()}
    assert names == {f"own{end}.parquet" for end in ("", ".examined", ".attempts")}


@pytest.mark.parametrize(
    ("detect", "changes", "rows", "what"),
    [
        (Aside(), {"attempts": 25}, slice(None), "settings"),
        (failing, {}, slice(None), "detector"),
        (Aside(), {}, slice(9), "objects"),
    ],
)
def test_a_folder_of_another_search_is_refused(
    whole, objects, tmp_path, detect, changes, rows, what
):
    store = Store(tmp_path, objects, Aside(), settings_of())
    store.write(0, search.Found(whole.examined, whole.attempts))
    with pytest.raises(UserError, match=rf"holds another search \(other {what}\); choose another"):
        search_failures(objects.iloc[rows], detect, settings_of(**changes), folder=tmp_path)


def test_a_detector_that_only_fails_ends_the_search_and_says_where_the_rest_is(
    whole, objects, tmp_path, monkeypatch
):
    monkeypatch.setattr(search, "LITTER", 3)
    given = settings_of(attempts=80)
    with pytest.raises(OnlyFailuresError, match=ONLY_FAILS) as stopped:
        search_failures(objects, failing, given, folder=tmp_path)
    assert "ZeroDivisionError" in stopped.value.failure
    assert not list(tmp_path.iterdir())
    store = Store(tmp_path, objects, failing, given)
    store.write(1, search.Found(whole.examined, whole.attempts))
    with pytest.raises(OnlyFailuresError) as stopped:
        search_failures(objects, failing, given, folder=tmp_path)
    _, where = str(stopped.value).splitlines()
    assert where == f"The results so far are in {tmp_path}; the same search resumes from there"


def test_a_detector_that_never_succeeds_is_told_of_once(objects, monkeypatch, caplog):
    monkeypatch.setattr(search, "DOUBTFUL", 3)
    with caplog.at_level(logging.WARNING, "egad"):
        found = search_failures(objects, Aside(), settings_of(attempts=8))
    assert not found.attempts.loc[found.attempts["who"] == "detector", "success"].any()
    (told,) = [each.getMessage() for each in caplog.records]
    assert re.fullmatch(r"the detector succeeded in none of the first \d attempts", told)
