"""Which objects are in which scene: no object and no family in two splits."""

import re
from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from small_scenes import SPLIT_OF, parameters

from egad.bench import NAMED_PROTOCOLS, ClutterProtocol
from egad.errors import UserError
from egad.evolution import Lineage
from egad.learning.scenes import (
    SceneParameters,
    planned_scenes,
    scenes_of_shard,
    shard_count,
    split_objects,
)
from egad.learning.scenes.parameters import MAX_OBJECTS
from egad.learning.scenes.planning import with_objects

IDS = [f"object{number}" for number in range(100)]


def lineage(sizes):
    """Families of objects: each founder has children, named by numbers one after the other."""
    names, parents, first = [], [], 0
    for family, size in enumerate(sizes):
        names += [f"founder{family}", *IDS[first : first + size]]
        parents += [[], *[[f"founder{family}"]] * size]
        first += size
    return Lineage(pd.DataFrame({"id": names, "parents": parents}))


def test_no_family_is_in_two_splits():
    sizes = [40, 20, 15, 10, 5, 4, 3, 2, 1]
    known, settings = lineage(sizes), parameters(validation=0.1, test=0.1)
    found = split_objects(IDS, known, (), settings)
    assert set(found.split_of) == set(IDS)
    assert (found.families, found.held_out) == (len(sizes), 0)
    by_family = {}
    for name, split in found.split_of.items():
        by_family.setdefault(known.family(name), set()).add(split)
    assert max(map(len, by_family.values())) == 1
    counts = Counter(found.split_of.values())
    assert counts["train"] >= 80
    assert min(counts["validation"], counts["test"]) >= 5
    assert split_objects(IDS[::-1], known, (), settings).split_of == found.split_of


def test_without_ancestors_objects_are_split():
    found = split_objects(IDS, None, (), parameters(validation=0.2, test=0.1))
    assert Counter(found.split_of.values()) == {"train": 70, "validation": 20, "test": 10}
    assert found.families == 0
    strangers = lineage([3])  # lacks most of the objects
    other = split_objects(IDS, strangers, (), parameters(validation=0.2, test=0.1))
    assert other == found


def test_the_evaluation_set_is_held_out_with_parents_and_children():
    known = Lineage(
        pd.DataFrame(
            {
                "id": ["f", "a", "b", "c", "d"],
                "parents": [[], ["f"], ["a"], ["b"], ["f"]],
            }
        )
    )
    found = split_objects(["a", "b", "c", "d"], known, {"b", "elsewhere"}, parameters())
    assert set(found.split_of) == {"d"}
    assert found.held_out == 3
    without = split_objects(["a", "c", "d"], known, {"b"}, parameters())
    assert (set(without.split_of), without.held_out) == ({"d"}, 2)


def test_scenes_have_the_objects_of_one_split():
    settings = parameters(scenes=200, validation=0.2, test=0.1, objects=5.0, pile=0.25)
    plan = planned_scenes(SPLIT_OF, settings)
    assert [each.round.number for each in plan] == list(range(200))
    assert Counter(each.split for each in plan) == {"train": 140, "validation": 40, "test": 20}
    assert Counter(each.round.scene for each in plan) == {"packed": 150, "pile": 50}
    for each in plan:
        assert {SPLIT_OF[name] for name in each.round.ids} == {each.split}
    assert {each.round.noise for each in plan} == {"none", "dex"}
    assert len({each.round.seed for each in plan}) == 200


def test_the_number_of_objects_is_one_and_a_poisson_number():
    ids = dict.fromkeys(IDS, "train")
    plan = planned_scenes(ids, parameters(scenes=2000, validation=0, test=0, objects=5.0))
    counts = np.array([len(each.round.ids) for each in plan])
    assert counts.min() == 1
    assert counts.max() <= MAX_OBJECTS
    assert counts.mean() == pytest.approx(5, abs=4 * 2 / 2000**0.5)
    assert counts.var() == pytest.approx(4, abs=0.6)


def test_sizes_and_repetition_are_those_of_the_protocol():
    settings = parameters(scenes=60, validation=0, test=0, objects=8.0, protocol="vgn")
    plan = planned_scenes({"a": "train", "b": "train"}, settings)
    packed = [n for each in plan if each.round.scene == "packed" for n in each.round.factors]
    piled = [n for each in plan if each.round.scene == "pile" for n in each.round.factors]
    assert 0.7 <= min(packed) < 0.75 < 0.85 < max(packed) <= 0.9
    assert 0.8 <= min(piled) < 0.85 < 0.95 < max(piled) <= 1.0
    assert max(len(each.round.ids) for each in plan) > 2


def test_a_scene_does_not_depend_on_the_number_of_scenes():
    ids = dict.fromkeys(IDS, "train")
    none = {"validation": 0, "test": 0}
    few, many = (planned_scenes(ids, parameters(scenes=n, **none)) for n in (5, 500))
    assert many[:5] == few


def test_scenes_without_some_objects_are_otherwise_the_same():
    plan = planned_scenes(SPLIT_OF, parameters(scenes=40, objects=2.0))
    left = {name for name in SPLIT_OF if name not in ("box0", "box5")}
    found = {each.round.number: each for each in with_objects(plan, left)}
    for planned in plan:
        pairs = [*zip(planned.round.ids, planned.round.factors, strict=True)]
        kept = [pair for pair in pairs if pair[0] in left]
        assert bool(kept) == (planned.round.number in found)
        if kept:
            other = found[planned.round.number]
            assert [*zip(other.round.ids, other.round.factors, strict=True)] == kept
            same = other.round._replace(ids=planned.round.ids, factors=planned.round.factors)
            assert other._replace(round=same) == planned
    assert 0 < len(found) < 40


def test_each_scene_is_in_one_shard():
    plan = planned_scenes(SPLIT_OF, parameters(scenes=130))
    shards = shard_count(130)
    assert shards == 3
    parts = [scenes_of_shard(plan, number, shards, 130) for number in range(shards)]
    assert [each for part in parts for each in part] == plan
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


def test_splits_without_objects_have_no_scenes():
    plan = planned_scenes({"a": "train"}, parameters(scenes=10, validation=0.3, test=0.3))
    assert [each.round.number for each in plan] == list(range(4))
    with pytest.raises(UserError, match="1 scenes of 1 objects: no split has both"):
        planned_scenes({"a": "train"}, parameters(scenes=1, validation=0.6, test=0.3))


def test_settings_survive_their_values():
    """Of named protocols, with their cameras and noise, and of sections."""
    for protocol in (*NAMED_PROTOCOLS, {"friction": 0.5}):
        settings = parameters(protocol=protocol)
        values = settings.model_dump(mode="json")
        assert SceneParameters.model_validate(values) == settings


def test_the_page_names_all_keys_of_a_protocol():
    text = (Path(__file__).parents[3] / "docs/vision.md").read_text()
    (line,) = (part for part in text.split("\n- **") if part.startswith("Protocol**"))
    assert {*re.findall("`([a-z_]+)`", line)} == set(ClutterProtocol.model_fields)
