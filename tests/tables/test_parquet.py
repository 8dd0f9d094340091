from dataclasses import replace

import pandas as pd
import pytest

from egad import __version__
from egad.errors import TableError
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE
from egad.tables.objects import OBJECTS, REJECTED
from egad.tables.origin import Origin, made_by

ROW = {"id": "a", "stage": "postprocess", "reason": "no volume"}


def test_round_trip_keeps_values_metadata_and_bytes(tmp_path):
    frame = pd.DataFrame([ROW, ROW | {"id": "b"}])
    for name in ("one", "two"):
        parquet.write(frame.sample(frac=1, axis=1), REJECTED, tmp_path / name)
    assert parquet.read(tmp_path / "one", REJECTED).equals(frame)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()
    stored = parquet.pq.read_schema(tmp_path / "one")
    assert stored.field("reason").metadata == REJECTED.field("reason").metadata


def test_an_empty_table_keeps_its_columns(tmp_path):
    parquet.write(pd.DataFrame([]), OBJECTS, tmp_path / "objects")
    frame = parquet.read(tmp_path / "objects", OBJECTS)
    assert list(frame.columns) == OBJECTS.names
    assert len(frame) == 0


@pytest.mark.parametrize("content", [b"", b"PAR1", b"not parquet at all"])
def test_a_damaged_file_is_named(tmp_path, content):
    path = tmp_path / "damaged.parquet"
    path.write_bytes(content)
    with pytest.raises(TableError, match=r"damaged\.parquet"):
        parquet.read(path, REJECTED)


def test_a_table_of_an_older_version_is_read_or_its_version_is_named(tmp_path):
    path, older = tmp_path / "table.parquet", Origin(program="0.0.9", stage="postprocess", code="")
    with made_by(older):
        parquet.write(pd.DataFrame([ROW]), REJECTED, path)
    assert parquet.read(path, REJECTED).to_dict("records") == [ROW]
    ours = f"egad 0.0.9 wrote it, this is egad {__version__}: make it again"
    with pytest.raises(TableError, match=f"columns are missing: .*complexity.*; {ours}"):
        parquet.read(path, OBJECTS)
    with made_by(replace(older, program=__version__)):
        parquet.write(pd.DataFrame([ROW]), REJECTED, path)
    with pytest.raises(TableError, match=r"columns are missing: [^;]*; make it again$"):
        parquet.read(path, OBJECTS)


def test_a_column_of_an_older_version_is_not_misread_but_named(tmp_path):
    path, schema = tmp_path / "archive.parquet", ARCHIVE
    for name in ("graspability", "graspability_std"):
        old = schema.field(name).with_name(name.replace("graspability", "difficulty"))
        schema = schema.set(schema.get_field_index(name), old)
    parquet.write(parquet.empty(schema), schema, path)
    said = (
        r"graspability, graspability_std \(difficulty is now graspability, difficulty_std is now "
    )
    with pytest.raises(TableError, match=said):
        parquet.read(path, ARCHIVE)


def test_a_missing_column_does_not_leave_a_file(tmp_path):
    with pytest.raises(KeyError):
        parquet.write(pd.DataFrame([{"id": "a"}]), REJECTED, tmp_path / "table")
    assert not (tmp_path / "table").exists()
