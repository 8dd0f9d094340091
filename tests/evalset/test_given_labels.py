"""An evaluation set that has been chosen already keeps its objects and labels."""

import numpy as np
import pandas as pd
import pytest

from egad.errors import UserError
from egad.evalset import SelectEval, labels_by_name, read_labels, take
from egad.tables.objects import OBJECTS

GRID = SelectEval(rows=3, columns=4)
DISTANCES = np.array(
    [[0, 0.3, 0.9, 0.5], [0.3, 0, 0.2, 0.6], [0.9, 0.2, 0, 0.1], [0.5, 0.6, 0.1, 0]]
)


def objects(*ids):
    """All in the hardest cell as measured, which must not matter."""
    known = {"id": list(ids), "label": [f"X{n:02d}_0" for n in range(len(ids))]}
    values = {"complexity": 9.0, "graspability": 0.0, "complexity_cell": 24, "difficulty_cell": 24}
    return pd.DataFrame(known).assign(**values).reindex(columns=OBJECTS.names)


def test_objects_named_as_labels_are_the_set_and_the_others_are_not():
    labels = labels_by_name(["B3", "mug", "A0"])
    table = take(objects("B3", "mug", "A0", "C1"), labels, DISTANCES, GRID)
    assert table["label"].tolist() == table["id"].tolist() == ["A0", "B3"]
    assert table["object_label"].tolist() == ["X02_0", "X00_0"]
    assert table[["row", "column"]].to_numpy().tolist() == [[0, 0], [1, 3]]
    assert not table["borrowed"].any()
    assert table["nearest"].tolist() == [0.9, 0.9]  # among the set, not to the mug


def test_a_file_says_which_object_has_which_label(tmp_path, caplog):
    path = tmp_path / "labels.csv"
    path.write_text("Label, note ,ID\nC2,,mug\nA1,x,bowl\nB0,,lost\n")
    labels = read_labels(path)
    assert labels == {"mug": "C2", "bowl": "A1", "lost": "B0"}
    table = take(objects("mug", "cup", "bowl", "can"), labels, DISTANCES, GRID)
    assert dict(zip(table["id"], table["label"], strict=True)) == {"bowl": "A1", "mug": "C2"}
    assert "not in the dataset: lost" in caplog.text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the column id is missing"),
        ("id,name\nmug,C2\n", "the column label is missing"),
        ("id,label\n,C2\n", "line 2: the id is missing"),
        ("id;label\n\nmug;C2\n\nmug;C3\n", "line 5: the object mug has two labels"),
        ("id,label\nmug,C22\n", "line 2: label is 'C22'; allowed: labels such as C4"),
        ("id,label\nmug\n", "line 2: label is ''"),
        ("id,label\n\xff\x00", "not a CSV file"),
    ],
)
def test_a_wrong_file_is_told_with_its_line(tmp_path, text, message):
    path = tmp_path / "labels.csv"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(UserError, match=message):
        read_labels(path)


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ({}, "no object has a label"),
        ({"a": "A0", "b": "A0"}, "the same label: A0"),
        ({"a": "D0"}, "D0 lies outside the grid, which ends at C3"),
    ],
)
def test_labels_that_make_no_set_are_refused(labels, message):
    with pytest.raises(UserError, match=message):
        take(objects("a", "b", "c", "d"), labels, DISTANCES, GRID)
