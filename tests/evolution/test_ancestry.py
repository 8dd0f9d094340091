from collections import Counter
from pathlib import Path

import pandas as pd
import pytest

import egad
from egad.data import released as released_archive
from egad.errors import UserError
from egad.evolution import Lineage, ancestors
from egad.tables import parquet
from egad.tables.evolution import LINEAGE


def lineage(*rows):
    """Rows of id, parents, epoch, step, island."""
    return pd.DataFrame(rows, columns=["id", "parents", "epoch", "step", "island"])


FAMILY = lineage(
    ("e", ["d"], 1, 0, 0),
    ("a", [], 0, 0, 0),
    ("b", [], 0, 0, 1),
    ("x", [], 0, 1, 0),  # nobody's parent
    ("c", ["a", "b"], 0, 2, 0),
    ("d", ["c"], 0, 3, 0),
    ("a", ["d"], 1, 1, 0),  # found again later
)


@pytest.fixture(scope="module")
def released():
    return egad.load("released")


def test_everybody_up_to_the_founders_is_there_in_order_of_birth():
    table = ancestors(["e"], FAMILY)
    assert table["id"].tolist() == ["a", "b", "c", "d", "e"]


def test_what_was_found_again_counts_from_the_first_time():
    table = ancestors(["a"], FAMILY)
    assert table["id"].tolist() == ["a"]
    assert table["parents"].tolist() == [[]]


def test_parents_are_older_than_their_children():
    table = ancestors(["e", "a"], FAMILY)
    place = {name: number for number, name in enumerate(table["id"])}
    for name, parents in zip(table["id"], table["parents"], strict=True):
        assert all(place[parent] < place[name] for parent in parents)


def test_a_gap_is_an_error():
    with pytest.raises(UserError, match="the object c is missing"):
        ancestors(["e"], FAMILY[FAMILY["id"] != "c"])


def test_a_line_follows_first_parents_to_a_founder():
    found = Lineage(ancestors(["e"], FAMILY))
    assert found.line("e") == ["e", "d", "c", "a"]
    assert found.family("e") == "a"
    assert found.founders("e") == ["a", "b"]
    assert found.parents("c") == ("a", "b")
    assert found.children("b") == ("c",)
    assert found.children("e") == ()
    assert found.line("b") == found.founders("b") == ["b"]


def test_a_child_of_one_parent_twice_is_one_child():
    twice = lineage(("a", [], 0, 0, 0), ("b", ["a", "a"], 0, 1, 0))
    assert Lineage(twice).children("a") == ("b",)


def test_unknown_objects_have_no_lineage():
    found = Lineage(FAMILY[:3])
    for ask in (found.parents, found.children, found.line, found.family, found.founders):
        with pytest.raises(UserError, match="object z are unknown"):
            ask("z")


def test_released_objects_descend_from_random_genomes(released):
    """Parents have children, and a slow search by recursion finds the same founders."""
    found = released.lineage

    def slow(name):
        parents = found.parents(name)
        return {name} if not parents else set().union(*map(slow, parents))

    young = [each.id for each in released if len(found.line(each.id)) < 5]
    assert len(young) > 5
    for name in young:
        assert found.family(name) in found.founders(name)
        assert all(name in found.children(parent) for parent in found.parents(name))
        assert set(found.founders(name)) == slow(name)
    assert all(not found.parents(name) for name in {found.family(each.id) for each in released})


def test_families_are_as_large_as_the_docs_say(released):
    sizes = Counter(released.lineage.family(each.id) for each in released).values()
    text = (Path(__file__).parents[2] / "docs/released.md").read_text(encoding="utf-8")
    largest = ", ".join(map(str, sorted(sizes, reverse=True)[:4]))
    assert f"{len(sizes)} families; the largest have {largest} objects" in " ".join(text.split())


def test_a_selection_and_a_run_of_released_objects_know_their_lineage(released, tmp_path):
    chosen = released.select("M14_3")
    line = chosen.lineage.line(chosen["M14_3"].id)
    copied = tmp_path / "archive.parquet"
    copied.write_bytes(released_archive().read_bytes())
    assert egad.load(copied).lineage.line(line[0]) == line
    shorter = chosen.lineage.table
    parquet.write(shorter[shorter["id"] == line[-1]], LINEAGE, tmp_path / "ancestry.parquet")
    assert egad.load(copied).lineage.line(line[-1]) == line[-1:]
    with pytest.raises(UserError, match="not in the table"):
        egad.load(copied).lineage.line(line[0])
