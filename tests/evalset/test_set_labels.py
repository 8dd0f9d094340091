"""Names of places in the evaluation set."""

import pytest

from egad.evalset.selection import LABEL, label_at, labels_of, place


def test_every_place_has_a_name_that_tells_it():
    names = labels_of(26, 10)
    assert len(set(names)) == 260
    assert [label_at(*place(name)) for name in names] == names
    assert [place(name) for name in labels_of(2, 2)] == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert all(LABEL.fullmatch(name) for name in names)


@pytest.mark.parametrize(
    "name", ["", "A", "4", "a0", "A00", "A10", "AA", "\N{GREEK CAPITAL LETTER ALPHA}0"]
)
def test_what_is_no_name(name):
    assert not LABEL.fullmatch(name)
