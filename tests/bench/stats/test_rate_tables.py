"""Rates of objects: what is read, from attempts or from what papers publish."""

import numpy as np
import pandas as pd
import pytest

from egad.bench.stats import read, read_rates
from egad.errors import TableError, UserError
from egad.tables import parquet
from egad.tables.evaluation import RESULTS


@pytest.fixture
def written(tmp_path):
    def write(text, name="published.csv"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_attempts_are_counted_by_object(written, tmp_path):
    text = "label,attempt,success,detector\nA0,0,1,mine\nA0,1,0,mine\nB1,0,1,mine\nA0,0,1,other\n"
    path = written(text)
    found = read_rates(path)
    assert list(found) == ["mine", "other"]
    assert found["mine"].to_dict("index") == {
        "A0": {"rate": 0.5, "attempts": 2},
        "B1": {"rate": 1.0, "attempts": 1},
    }
    parquet.write(pd.concat(read(path).values()), RESULTS, tmp_path / "results.parquet")
    for name, table in read_rates(tmp_path / "results.parquet").items():
        pd.testing.assert_frame_equal(table, found[name])


def test_rates_that_others_published_are_read(written):
    (name, table), *others = read_rates(written("label,success_rate\nB1,85 %\nA0,.25\n")).items()
    assert (name, others) == ("published", [])
    assert table["rate"].to_dict() == {"A0": 0.25, "B1": 0.85}
    assert np.isnan(table["attempts"]).all()


def test_successes_and_attempts_are_read(written):
    text = "Label;Successes;Attempts;Detector;Note\nA0;5;20;mine;\nB1;0;10;mine;hard\nA0;9;9;x;\n"
    found = read_rates(written(text))
    assert found["mine"].to_numpy().tolist() == [[0.25, 20], [0, 10]]
    assert found["x"].to_numpy().tolist() == [[1, 9]]


def test_a_rate_may_say_how_many_attempts_it_is_of(written):
    text = "label,success_rate,attempts\nA0,0.5,20\nB1,100%,\nC2,,20\n"  # C2 was not tried
    table = read_rates(written(text))["published"]
    assert list(table.index) == ["A0", "B1"]
    assert table.loc["A0"].tolist() == [0.5, 20]
    assert table.loc["B1", "rate"] == 1
    assert np.isnan(table.loc["B1", "attempts"])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not a CSV file: it is empty"),
        ("object,success_rate\nA0,0.5\n", "the column label is missing; needed: label, attempt"),
        ("label,success_rate\nA0,0.5\nA0,0.6\n", "the object A0 occurs twice"),
        ("label,success_rate\nA0,\n", "no row has a success rate"),
        ("label,success_rate\nA0,85\n", "line 2: success_rate is '85'; allowed: 0 to 1, or a"),
        ("label,success_rate,attempts\nA0,0.5,0\n", "line 2: attempts is '0'; allowed: a whole nu"),
        ("label,successes,attempts\nA0,6,5\n", "line 2: successes is '6'; .* at most the 5 attem"),
        ("label,attempts,attempts,successes\nA0,5,5,5\n", "the column attempts occurs twice"),
    ],
)
def test_mistakes_in_rates_are_named_with_their_line(written, text, words):
    with pytest.raises(UserError, match=words):
        read_rates(written(text))


def test_what_is_no_table_is_told(written):
    with pytest.raises(TableError):
        read_rates(written("PAR1", "broken.parquet"))
