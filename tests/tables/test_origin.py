import json
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
import pytest

from egad.tables import parquet
from egad.tables.objects import REJECTED
from egad.tables.origin import Origin, made_by

ROW = pd.DataFrame([{"id": "a", "stage": "b", "reason": "c"}])


def origin(*inputs):
    return Origin("1.0", "collect", "c0de", "5e77", 7, {"shard": 1}, inputs)


def write(path, made):
    with made_by(made):
        parquet.write(ROW, REJECTED, path, {"seed": 7})
    return parquet.origin_of(path)


def test_a_table_keeps_its_origin_as_metadata_of_its_schema(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = tmp_path / "in/a.parquet"
    noted = write(tmp_path / "out/deep/b.parquet", origin((source, "12ab")))
    assert noted == {
        "program": "1.0",
        "stage": "collect",
        "code": "c0de",
        "settings": "5e77",
        "seed": 7,
        "arguments": {"shard": 1},
        "inputs": [["../../in/a.parquet", "12ab"]],
    }
    stored = pq.read_schema(tmp_path / "out/deep/b.parquet").metadata
    assert json.loads(stored[b"egad-origin"]) == noted
    assert parquet.notes(tmp_path / "out/deep/b.parquet") == {"seed": 7}


def test_without_an_origin_none_is_kept(tmp_path):
    parquet.write(ROW, REJECTED, tmp_path / "a")
    assert parquet.origin_of(tmp_path / "a") == {}


@pytest.mark.parametrize("fails", [False, True])
def test_an_origin_ends_with_its_block(tmp_path, fails):
    try:
        with made_by(origin()):
            assert not fails or 1 / 0
    except ZeroDivisionError:
        pass
    parquet.write(ROW, REJECTED, tmp_path / "a")
    assert parquet.origin_of(tmp_path / "a") == {}


def test_the_place_of_the_working_directory_leaves_no_trace(tmp_path, monkeypatch):
    files = []
    for name in ("one", "two/deeper"):
        here = tmp_path / name
        here.mkdir(parents=True)
        monkeypatch.chdir(here)
        outside = tmp_path / name / "../../elsewhere/archive.parquet"
        write(
            here / "results/a.parquet", origin((here / "b.parquet", "1"), (outside.resolve(), "2"))
        )
        files.append((here / "results/a.parquet").read_bytes())
    assert files[0] == files[1]
    assert parquet.origin_of(here / "results/a.parquet")["inputs"] == [
        ["../b.parquet", "1"],
        ["elsewhere:archive.parquet", "2"],
    ]


@pytest.mark.parametrize("name", ["../x.parquet", "results/../../x.parquet"])
def test_an_input_outside_is_noted_by_its_name_however_it_is_written(tmp_path, monkeypatch, name):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    noted = write(Path("results/a.parquet"), origin((Path(name), "1"), (Path("x/../b"), "2")))
    assert noted["inputs"] == [["elsewhere:x.parquet", "1"], ["../b", "2"]]
