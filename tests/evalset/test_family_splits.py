"""Relatives are in one split, told from the table of ancestors alone; nothing else decides."""

from collections import Counter

import numpy as np
import pandas as pd
import pytest

from egad.data import evaluation_set, released, released_ancestry
from egad.evalset.family_splits import families, split_by_family, with_parents_and_children
from egad.evolution import Lineage
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE, LINEAGE


@pytest.fixture(scope="module")
def ancestry():
    return parquet.read(released_ancestry(), LINEAGE)


@pytest.fixture(scope="module")
def ids():
    return list(parquet.read(released(), ARCHIVE)["id"])


@pytest.fixture(scope="module")
def chosen():
    return list(pd.read_csv(evaluation_set())["id"])


def splits(ids, chosen, ancestry, validation=0.15):
    lineage = Lineage(ancestry)
    test = with_parents_and_children(chosen, lineage)
    return split_by_family(families(ids, lineage), test, validation, 0)


def test_no_first_parent_and_child_are_in_training_and_validation(ids, chosen, ancestry):
    found = splits(ids, chosen, ancestry)
    pairs = [
        {found[child], found[parents[0]]}
        for child, parents in zip(ancestry["id"], ancestry["parents"], strict=True)
        if child in found and len(parents) and parents[0] in found
    ]
    assert len(pairs) > 1000
    assert {"train", "validation"} not in pairs


def test_families_are_those_that_a_walk_over_the_table_finds(ids, chosen, ancestry):
    first = {
        child: parents[0]
        for child, parents in zip(ancestry["id"], ancestry["parents"], strict=True)
        if len(parents)
    }
    found = splits(ids, chosen, ancestry)
    founders = {"train": set(), "validation": set(), "test": set()}
    for name in ids:
        oldest = name
        while oldest in first:
            oldest = first[oldest]
        founders[found[name]].add(oldest)
    assert founders["train"].isdisjoint(founders["validation"])
    assert founders["validation"]


def test_the_evaluation_set_is_tested_with_its_parents_and_children(ids, chosen, ancestry):
    found = splits(ids, chosen, ancestry)
    assert {found[name] for name in chosen} == {"test"}
    for child, parents in zip(ancestry["id"], ancestry["parents"], strict=True):
        for parent in parents:
            pair = {child, parent} & set(found)
            if {child, parent} & set(chosen):
                assert {found[name] for name in pair} == {"test"}


def test_most_objects_are_for_training(ids, chosen, ancestry):
    count = Counter(splits(ids, chosen, ancestry).values())
    assert 0 < count["validation"] <= 0.15 * (count["train"] + count["validation"])
    assert Counter(splits(ids, chosen, ancestry, 0.0).values())["validation"] == 0


def test_order_decides_nothing(ids, chosen, ancestry):
    shuffled = np.random.default_rng(0).permutation(ids).tolist()
    found = splits(shuffled, chosen[::-1], ancestry.sample(frac=1, random_state=3))
    assert found == splits(ids, chosen, ancestry)


def test_without_ancestors_each_object_is_a_family():
    names = [f"mug-{number}" for number in range(100)]
    assert with_parents_and_children(names[:3], None) == set(names[:3])
    found = split_by_family(families(names, None), names[:10], 0.2, 0)
    assert Counter(found.values()) == {"test": 10, "train": 72, "validation": 18}
    assert found != split_by_family(families(names, None), names[:10], 0.2, 1)
