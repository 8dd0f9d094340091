import pandas as pd
import pytest

from egad.errors import UserError
from egad.map_elites.ancestry import ancestors


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
