"""Tables of strangers: bombs, names that are paths, other types, and damaged ones."""

import contextlib
import tracemalloc

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from egad.cppn.surface import packed_surface
from egad.data import released
from egad.errors import RejectedError, TableError, UserError
from egad.pipeline.config import Settings
from egad.pipeline.stages import export_meshes
from egad.tables import parquet, promises
from egad.tables.columns import ID, LABEL
from egad.tables.evolution import ARCHIVE
from egad.tables.grasping import GRASPS, SCALES
from egad.tables.pages import pages

SCHEMA = pa.schema([("id", pa.string()), ("voxels", pa.large_binary()), ("x", pa.float64())])


def repeated(value, count, kind):
    zeros = pa.array(np.zeros(count, np.int32))
    return pa.DictionaryArray.from_arrays(zeros, pa.array([value], kind))


def table(path, count, name="a", voxels=b""):
    rows = {
        "id": repeated(name, count, pa.string()),
        "voxels": repeated(voxels, count, pa.binary()),
        "x": pa.array(np.zeros(count)),
    }
    pq.write_table(pa.table(rows), path, compression="zstd", store_schema=False)
    return path


@pytest.mark.parametrize(
    "size", [{"count": 5000, "voxels": bytes(1 << 20)}, {"count": 5000, "name": "a" * (1 << 20)}]
)
def test_a_small_file_that_unfolds_to_gigabytes_is_refused(tmp_path, size):
    path = table(tmp_path / "bomb.parquet", **size)
    assert path.stat().st_size < 3000
    with pytest.raises(TableError, match=r"bomb\.parquet: 5,\d+,\d+,\d+ bytes in memory"):
        parquet.read(path, SCHEMA)
    with pytest.raises(TableError, match="bytes in memory"):
        next(parquet.batches(path, ["id", "voxels"]))


def test_more_rows_than_memory_are_refused_unread(tmp_path, monkeypatch):
    monkeypatch.setattr(promises, "MOST_BYTES", 100_000_000)
    path = table(tmp_path / "long.parquet", 5_000_000)
    assert path.stat().st_size < 100_000
    tracemalloc.start()
    before = pa.total_allocated_bytes()
    with pytest.raises(TableError, match="bytes in memory"):
        parquet.read(path, SCHEMA)
    assert tracemalloc.get_traced_memory()[1] < 10_000_000
    assert pa.total_allocated_bytes() - before < 10_000_000
    tracemalloc.stop()


def test_many_short_texts_are_read(tmp_path):
    path = table(tmp_path / "grasps.parquet", 300_000, name="a" * 20_000)
    with pytest.raises(TableError, match=r"4,\d+,\d+,\d+ bytes in memory"):
        parquet.read(path, SCHEMA)
    path = table(tmp_path / "grasps.parquet", 300_000, name="a" * 20)
    assert len(parquet.read(path, SCHEMA)) == 300_000


def with_footer(path, change):
    """A file whose footer says something else, in as many bytes."""
    data = path.read_bytes()
    start = len(data) - 8 - int.from_bytes(data[-8:-4], "little")
    footer = change(data[start:-8])
    assert len(footer) == len(data) - 8 - start
    path.write_bytes(data[:start] + footer + data[-8:])


def varint(value):
    value, parts = 2 * value, []
    while value:
        parts.append(value & 127 | 128)
        value >>= 7
    return bytes([*parts[:-1], parts[-1] & 127])


@pytest.mark.parametrize("kind", ["name", "voxels"])
def test_a_footer_that_tells_of_less_is_not_believed(tmp_path, kind):
    text = "a" * (1 << 20)
    path = table(
        tmp_path / "bomb.parquet", 5000, **{kind: text if kind == "name" else text.encode()}
    )
    group = pq.ParquetFile(path).metadata.row_group(0)
    size = varint(group.column(0 if kind == "name" else 1).total_uncompressed_size)
    padded = b"\x82" + b"\x80" * (len(size) - 2) + b"\0"
    with_footer(path, lambda footer: footer.replace(size, padded))
    group = pq.ParquetFile(path).metadata.row_group(0)
    assert group.column(0 if kind == "name" else 1).total_uncompressed_size == 1
    before = pa.total_allocated_bytes()
    with pytest.raises(TableError, match=r"bytes in memory"):
        parquet.read(path, SCHEMA)
    assert pa.default_memory_pool().max_memory() - before < 200_000_000
    with pytest.raises(TableError, match="bytes in memory"):
        next(parquet.batches(path, ["id", "voxels"]))


def test_pages_are_as_the_footer_of_a_sound_file_says(tmp_path):
    frame = pd.DataFrame(
        {
            "a": np.arange(50_000),
            "b": [str(k % 99) for k in range(50_000)],
            "c": [[str(k), "x"] for k in range(50_000)],
            "d": [None, 1.5] * 25_000,
        }
    )
    for number, options in enumerate(
        [
            {},
            {"data_page_version": "2.0"},
            {"row_group_size": 999},
            {"compression": "none"},
            {"use_dictionary": False, "write_page_index": True, "data_page_size": 1000},
        ]
    ):
        path = tmp_path / f"{number}.parquet"
        pq.write_table(pa.Table.from_pandas(frame), path, **options)
        about = pq.ParquetFile(path).metadata
        for group in range(about.num_row_groups):
            for column in range(about.num_columns):
                chunk = about.row_group(group).column(column)
                found = list(pages(path, chunk))
                whole = sum(page.size for page in found)
                assert 0 <= chunk.total_uncompressed_size - whole < 100 * len(found)  # headers
                data = found[1:] if chunk.has_dictionary_page else found
                assert sum(page.values for page in data) == chunk.num_values
        assert len(parquet.read(path, pq.read_schema(path))) == 50_000


def test_wide_values_that_are_not_there_are_counted(tmp_path):
    kind = pa.binary(100_000_000)
    frame = pa.Table.from_arrays([pa.nulls(1, kind)], ["a"])
    pq.write_table(frame, tmp_path / "a.parquet", store_schema=False)
    assert len(parquet.read(tmp_path / "a.parquet", pa.schema([("a", kind)]))) == 1
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(promises, "MOST_BYTES", 90_000_000)
        with pytest.raises(TableError, match="bytes in memory"):
            parquet.read(tmp_path / "a.parquet", pa.schema([("a", kind)]))


def test_texts_that_share_their_beginnings_are_refused(tmp_path):
    """Each may be as long as all that is in the file, and they are unpacked together."""
    rows = pa.table({"id": ["a" * 1_000_000] * 100})
    options = {"use_dictionary": False, "column_encoding": {"id": "DELTA_BYTE_ARRAY"}}
    pq.write_table(rows, tmp_path / "a.parquet", **options)
    with pytest.raises(TableError, match="DELTA_BYTE_ARRAY"):
        parquet.read(tmp_path / "a.parquet", pa.schema([ID]))


@pytest.mark.parametrize("name", ["../a", "/etc/a", "..", ".", "a\\b", "a\0b", "a/b"])
def test_labels_that_are_paths_are_refused(tmp_path, name):
    path = tmp_path / "names.parquet"
    pd.DataFrame({"id": ["some/object"], "label": [name]}).to_parquet(path)
    with pytest.raises(TableError, match="cannot be the name of a file"):
        parquet.read(path, pa.schema([ID, LABEL]))
    with pytest.raises(TableError, match="cannot be the name of a file"):
        list(parquet.batches(path, ["label"]))
    assert len(parquet.read(path, pa.schema([ID]))) == 1


@pytest.mark.parametrize("name", ["M14_3", "mug.v2", "..a", "Tasse blau", "杯"])
def test_other_labels_are_taken(tmp_path, name):
    path = tmp_path / "names.parquet"
    pd.DataFrame({"id": ["a"], "label": [name]}).to_parquet(path)
    assert parquet.read(path, pa.schema([LABEL]))["label"].tolist() == [name]


def test_an_archive_writes_nothing_outside_its_folder(tmp_path):
    frame = parquet.read(released(), ARCHIVE).head(2).assign(id=["fine", "../outside"])
    parquet.write(frame, ARCHIVE, tmp_path / "archive.parquet")
    with pytest.raises(TableError, match="outside"):
        export_meshes.run(tmp_path / "archive.parquet", tmp_path / "made/meshes", Settings().shape)
    assert {path.name for path in tmp_path.rglob("*")} == {"archive.parquet"}


def test_types_of_other_programs_are_converted_and_wrong_ones_named(tmp_path):
    path = tmp_path / "table.parquet"
    rows = {name: [1] for name in SCALES.names} | {"label": ["a"], "rule": ["paper"]}
    pd.DataFrame(rows).astype({"label": "category"}).to_parquet(path)
    assert parquet.read(path, SCALES)["factor"].dtype == np.float64
    assert parquet.read(path, SCALES)["label"].tolist() == ["a"]
    pd.DataFrame(rows | {"factor": ["wide"]}).to_parquet(path)
    with pytest.raises(TableError, match=r"table\.parquet: .*wide"):
        parquet.read(path, SCALES)


VOXELS = (25**3 + 7) // 8


@pytest.mark.parametrize("length", [0, 1, VOXELS - 1, VOXELS + 1, 10 * VOXELS])
def test_voxels_of_another_size_are_refused(length):
    with pytest.raises(UserError, match=f"{length} bytes of voxels"):
        packed_surface(bytes(length), Settings().shape)


def test_an_object_without_voxels_is_rejected():
    with pytest.raises(RejectedError, match="no solid voxel"):
        packed_surface(bytes(VOXELS), Settings().shape)


QUIET = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
MANY = settings(max_examples=20_000, deadline=None, database=None, suppress_health_check=QUIET)
SOME = settings(MANY, max_examples=150, derandomize=True)
KEPT = {}


@pytest.fixture
def archive(tmp_path):
    """A path for a table, and the bytes of a small archive."""
    if not KEPT:
        frame = parquet.read(released(), ARCHIVE).head(5)
        parquet.write(frame, ARCHIVE, tmp_path / "whole", {"seed": 1})
        KEPT["whole"] = (tmp_path / "whole").read_bytes()
    return tmp_path / "any.parquet", KEPT["whole"]


@pytest.fixture
def stranger(archive):
    """The same of a table that has no seal, and where its footer begins.

    Only the seal keeps pyarrow from footers that end the process: these stay as they are.
    """
    path, whole = archive
    path.write_bytes(whole)
    pq.write_table(pq.read_table(path).replace_schema_metadata(), path)
    bare = path.read_bytes()
    return path, bare, len(bare) - 8 - int.from_bytes(bare[-8:-4], "little")


@st.composite
def changes(draw):
    """Places in a file, in parts of its length, and what to write there; how much to keep."""
    words = st.sampled_from([b"\0", b"\xff", b"\x7f\xff\xff\xff", b"PAR1"]) | st.binary(max_size=6)
    places = st.floats(0, 1) | st.floats(0.6, 1)  # of these the second half is the footer
    return draw(st.lists(st.tuples(places, words), min_size=1, max_size=6)), draw(
        st.sampled_from([1.0, 1.0, 1.0, 0.9, 0.5])
    )


def read_or_refuse(path, whole, change):
    """What any file must do: be the columns of an archive, or be refused."""
    data, (places, kept) = bytearray(whole), change
    for place, word in places:
        start = int(place * (len(data) - 1))
        data[start : start + len(word)] = word
    path.write_bytes(data[: int(kept * len(data))])
    read_all(path)


def read_all(path):
    """Read it in every way; all that may be raised is that it cannot be read."""
    for read in (
        lambda: parquet.read(path, ARCHIVE),
        lambda: parquet.notes(path),
        lambda: parquet.origin_of(path),
        lambda: list(parquet.batches(path, ["id", "voxels"])),
    ):
        with contextlib.suppress(TableError):
            read()


def test_a_column_whose_name_is_no_text_is_refused(archive):
    """Found by the test below."""
    path, whole = archive
    path.write_bytes(whole.replace(b"complexity_cell", b"complexity\xffcell"))
    with pytest.raises(TableError, match="not a readable Parquet file"):
        parquet.notes(path)


def test_damaged_statistics_are_refused(archive):
    """Found by the test below: pyarrow ends the process when it is asked about such a column."""
    path, whole = archive
    footer = len(whole) - 8 - int.from_bytes(whole[-8:-4], "little")
    for place in range(footer, len(whole) - 8, 50):
        damaged = bytearray(whole)
        damaged[place] ^= 2
        path.write_bytes(damaged)
        with pytest.raises(TableError):
            parquet.read(path, ARCHIVE)


@SOME
@given(changes())
def test_damaged_archives_are_tables_or_refused(archive, change):
    read_or_refuse(*archive, change)


@pytest.mark.slow
@MANY
@given(changes())
def test_very_many_damaged_archives_are_tables_or_refused(archive, change):
    read_or_refuse(*archive, change)


def read_pages_or_refuse(path, bare, footer, change):
    """The same with changes to the pages alone."""
    data, (places, _) = bytearray(bare), change
    for place, word in places:
        start = int(place * (footer - len(word)))
        data[start : start + len(word)] = word
    path.write_bytes(data)
    read_all(path)


@SOME
@given(changes())
def test_damaged_pages_are_tables_or_refused(stranger, change):
    read_pages_or_refuse(*stranger, change)


@pytest.mark.slow
@MANY
@given(changes())
def test_very_many_damaged_pages_are_tables_or_refused(stranger, change):
    read_pages_or_refuse(*stranger, change)


def test_grasps_of_the_pipeline_are_read_as_before(tmp_path):
    frame = parquet.empty(GRASPS)
    parquet.write(frame, GRASPS, tmp_path / "grasps")
    assert parquet.read(tmp_path / "grasps", GRASPS).dtypes.equals(frame.dtypes)


def test_damaged_headers_of_pages_are_refused(tmp_path):
    """Without a seal nothing but the pages themselves says that they are damaged."""
    path = tmp_path / "a.parquet"
    pq.write_table(pa.table({"id": ["a", "b"], "label": ["c", "d"]}), path)
    whole = path.read_bytes()
    start = pq.read_metadata(path).row_group(0).column(0).data_page_offset
    for at in range(start, start + 24):
        for byte in (0, 0x15, 0x1C, 0x55, 0xFF):
            path.write_bytes(whole[:at] + bytes([byte]) + whole[at + 1 :])
            with contextlib.suppress(TableError):
                list(parquet.batches(path, ["id", "label"]))
