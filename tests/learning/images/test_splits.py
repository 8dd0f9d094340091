"""Splits are by object, budgets are kept, and neither depends on what else is rendered."""

import numpy as np
import pandas as pd
import pytest

from egad.learning.images import SPLITS, Render, evenly, shard_count, shares
from egad.learning.images.splits import split_of

RENDER = Render(images=1000)


def objects(count):
    rng = np.random.default_rng(count)
    ids = [f"id-{number}" for number in range(count)]
    return pd.DataFrame({"id": ids, "label": ids, "complexity": rng.random(count)})


def images_by_split(found):
    return {name: sum(s.images for s in found if s.split == name) for name in SPLITS}


@pytest.mark.parametrize("count", [3, 20, 300, 3000])
def test_the_budget_is_the_same_for_any_number_of_objects(count):
    found = shares(objects(count), [], RENDER, 0)
    assert images_by_split(found) == {"train": 800, "validation": 100, "test": 100}
    for name in SPLITS:
        images = [share.images for share in found if share.split == name]
        assert max(images) - min(images) <= 1
    assert [share.first for share in found] == np.cumsum(
        [0] + [share.images for share in found[:-1]]
    ).tolist()


def test_the_evaluation_set_is_never_trained_on():
    held_out = [f"id-{number}" for number in range(40, 89)]
    for count in (100, 1000):
        found = {share.id: share.split for share in shares(objects(count), held_out, RENDER, 0)}
        assert {found[name] for name in held_out} == {"test"}
        tested = sum(split == "test" for split in found.values())
        assert tested == max(49, count // 10)
    budgets = images_by_split(shares(objects(100), held_out, RENDER, 0))
    assert budgets == {"train": 800, "validation": 100, "test": 100}


def test_a_part_of_the_dataset_has_the_splits_of_the_whole():
    table = objects(300)
    whole = {share.id: share.split for share in shares(table, [], RENDER, 0)}
    simple = Render(images=1000, complexity=(0, 1 / 3))
    found = shares(table, [], simple, 0)
    assert {share.id for share in found} == set(table.nsmallest(100, "complexity")["id"])
    assert all(whole[share.id] == share.split for share in found)
    assert images_by_split(found)["train"] == 800
    thirds = [
        {share.id for share in shares(table, [], Render(complexity=part), 0)}
        for part in ((0, 1 / 3), (1 / 3, 2 / 3), (2 / 3, 1))
    ]
    assert set.union(*thirds) == set(table["id"])
    assert sum(map(len, thirds)) == 300


def test_a_part_is_drawn_by_chance_from_all_of_the_range():
    table = objects(300)
    whole = {share.id: share.split for share in shares(table, [], RENDER, 0)}
    settings = Render(images=1000, subset=1 / 3)
    found = shares(table, [], settings, 0)
    assert len(found) == 100
    assert all(whole[share.id] == share.split for share in found)
    assert images_by_split(found) == {"train": 800, "validation": 100, "test": 100}
    ranks = table.set_index("id")["complexity"].rank(pct=True)[[share.id for share in found]]
    assert abs(ranks.mean() - 0.5) < 0.1
    assert {share.id for share in shares(table, [], settings, 1)} != {each.id for each in found}
    simple = shares(table, [], Render(complexity=(0, 0.5), subset=0.1), 0)
    assert len(simple) == 15
    assert {each.id for each in simple} < set(table.nsmallest(150, "complexity")["id"])


def test_order_of_rows_does_not_matter_and_the_seed_does():
    table = objects(50)
    again = shares(table.sample(frac=1, random_state=1), [], RENDER, 0)
    assert again == shares(table, [], RENDER, 0)
    assert again != shares(table, [], RENDER, 1)


def test_few_objects_are_split_as_well_as_can_be():
    assert sorted(split_of(["a", "b", "c"], [], RENDER, 0).values()) == sorted(SPLITS)
    assert list(split_of(["a"], [], RENDER, 0).values()) == ["train"]
    assert split_of(["a", "b"], ["a", "b"], RENDER, 0) == {"a": "test", "b": "test"}
    assert shares(objects(0), [], RENDER, 0) == []
    nothing = Render(validation=0, test=0)
    assert set(split_of(list("abcdef"), [], nothing, 0).values()) == {"train"}


def test_numbers_are_cut_evenly():
    assert evenly(7, 3) == [2, 2, 3]
    assert evenly(2, 5) == [0, 0, 1, 0, 1]
    assert evenly(5, 0) == []
    assert (shard_count(1), shard_count(500), shard_count(501)) == (1, 1, 2)


def test_scenes_have_their_share_of_the_images_and_objects_of_one_split():
    table = objects(60)
    split = {share.id: share.split for share in shares(table, [], RENDER, 0)}
    settings = Render(images=1000, packed=0.2, pile=0.3, objects=4)
    found = shares(table, [], settings, 0)
    assert images_by_split(found) == {"train": 800, "validation": 100, "test": 100}
    for kind, images in (("single", 500), ("packed", 200), ("pile", 300)):
        assert sum(share.images for share in found if share.scene == kind) == images
    several = [share for share in found if share.scene != "single"]
    assert {len(share.members) for share in several} == {4}
    for share in several:
        assert len(set(share.members)) == 4
        assert {split[name] for name in share.members} == {share.split}
        assert 0 < share.images <= 4
    assert len({share.id for share in found}) == len(found)
    assert set().union(*(share.members for share in several)) > set(list(split)[:30])
