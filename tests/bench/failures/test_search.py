"""The search: what it looks at, what it spends, and that it goes on where it was cut off."""

import pandas as pd
import pytest
from failing import beside, nothing
from failure_searches import coarse_objects, settings_of

from egad.bench.failures import ObjectVerdict, attempts_of
from egad.bench.failures import search as stepwise
from egad.bench.failures.search import Search
from egad.bench.failures.store import joined

OBJECTS = coarse_objects()
FEW = OBJECTS[["C03_0", "H01_2", "E03_0", "G03_0"]].archive
CELL = ["complexity_cell", "difficulty_cell"]


def run(settings, detect=beside, archive=FEW, before=None, shard=0):
    """What a search finds, step by step."""
    search = Search(archive, detect, settings, shard, *([before] if before else []))
    return [before, *search.steps()] if before else list(search.steps())


def parameters(**search):
    return settings_of(**{"shards": 1} | search)


def same(first, second):
    pd.testing.assert_frame_equal(first.examined, second.examined)
    pd.testing.assert_frame_equal(first.attempts, second.attempts)


@pytest.fixture(scope="module")
def screened():
    return joined(run(parameters(strategy="screening")))


def test_screening_looks_at_every_object_of_the_archive_once(screened):
    found = screened
    assert set(found.examined["id"]) == set(FEW["id"])
    assert set(found.examined["source"]) == {"archive"}
    assert found.examined["attempts"].sum() == len(found.attempts)
    cells = found.examined.set_index("id")[CELL]
    known = FEW.set_index("id").loc[cells.index, CELL]
    assert cells.to_dict("index") == known.to_dict("index")


def test_shards_share_the_objects_and_the_attempts():
    settings = parameters(strategy="screening", shards=3, attempts=5)
    searches = [Search(FEW, beside, settings, shard) for shard in range(3)]
    assert [attempts_of(shard, settings.failures) for shard in range(3)] == [2, 2, 1]
    ids = [each.id for search in searches for each in search._targets]
    assert sorted(ids) == sorted(FEW["id"])


def test_attempts_end_a_search():
    found = joined(run(parameters(strategy="random", attempts=3), nothing))
    assert 3 <= len(found.attempts) < 3 + 60
    assert set(found.examined["source"]) == {"random"}
    assert found.examined["parents"].map(len).eq(0).all()


def test_evolution_breeds_failures_and_is_the_same_after_an_interruption(monkeypatch):
    monkeypatch.setattr(stepwise, "LITTER", 1)
    settings = parameters(strategy="evolution", attempts=30)
    steps = run(settings)
    whole = joined(steps)
    children = whole.examined[whole.examined["source"] == "child"]
    failures = whole.examined[whole.examined["verdict"] == ObjectVerdict.FAILURE]
    assert len(children)
    assert set().union(*children["parents"]) <= set(failures["id"])
    assert len(steps) > 3
    same(joined(run(settings, before=joined(steps[:3]))), whole)


def test_a_cell_full_of_failures_is_closed():
    twins = OBJECTS[["C03_0", "C03_1"]].archive
    assert len(twins[CELL].drop_duplicates()) == 1
    settings = parameters(strategy="screening", elites_per_cell=1)
    found = joined(run(settings, archive=twins)).examined
    assert list(found["verdict"]) == [ObjectVerdict.FAILURE, ObjectVerdict.CELL_FULL]
    assert list(found["attempts"] > 0) == [True, False]
