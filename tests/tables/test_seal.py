import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from egad.errors import TableError
from egad.tables import parquet
from egad.tables.objects import REJECTED
from egad.tables.seal import is_whole


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "table.parquet"
    rows = [{"id": str(k), "stage": "egad-seal:" + "0" * 64, "reason": ""} for k in range(100)]
    parquet.write(pd.DataFrame(rows), REJECTED, path)
    return path


def test_a_table_is_whole_as_it_was_written(table):
    assert is_whole(table)


def test_every_changed_byte_shows(table):
    whole = table.read_bytes()
    for place in range(0, len(whole), 7):
        changed = bytearray(whole)
        changed[place] ^= 1
        table.write_bytes(changed)
        assert not is_whole(table), place


def test_a_longer_or_shorter_file_is_not_whole(table):
    whole = table.read_bytes()
    for other in (whole + b"x", whole[:-1], b"x" + whole, whole[:9], b""):
        table.write_bytes(other)
        assert not is_whole(table)


def test_a_table_of_another_program_has_no_seal_and_can_be_read(tmp_path):
    path = tmp_path / "other.parquet"
    pd.DataFrame([{"id": "a", "stage": "mine", "reason": ""}]).to_parquet(path)
    assert is_whole(path) is None
    assert parquet.read(path, REJECTED)["stage"].tolist() == ["mine"]
    assert parquet.origin_of(path) == {}


@pytest.mark.parametrize("text", ["{", "[1]", "7"])
def test_notes_that_are_no_notes_are_named(tmp_path, text):
    path = tmp_path / "odd.parquet"
    table = pa.table({"id": ["a"]}).replace_schema_metadata({"egad": text, "egad-origin": text})
    pq.write_table(table, path)
    for read in (parquet.notes, parquet.origin_of):
        with pytest.raises(TableError, match=r"odd\.parquet: its metadata egad"):
            read(path)
