"""Untrusted tables: bombs, names that are paths, other types, and damaged ones."""

import contextlib
import re

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hostile_tables import BOMBS, SCHEMA, table
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from peak_memory import MEGABYTE, MEMORY, measured

from egad.cli.export_meshes import write_meshes
from egad.data import released
from egad.errors import RejectedError, TableError, UserError
from egad.evolution import packed_surface
from egad.tables import parquet
from egad.tables.columns import ID, LABEL
from egad.tables.evolution import ARCHIVE
from egad.tables.grasping import SCALES
from egad.tables.parquet import RowGroups
from egad_workflow.settings import Settings

SECONDS = 20  # that reading may take here
SPARE = 60  # for all else, on a busy machine


def whole(path):
    return f"{len(parquet.read(path, BOMBS.get(path.stem, (0, SCHEMA))[1]))} rows"


def streamed(path):
    names = BOMBS.get(path.stem, (0, SCHEMA))[1].names
    return f"{sum(map(len, parquet.batches(path, names)))} rows"


def by_groups(path):
    names = BOMBS.get(path.stem, (0, SCHEMA))[1].names
    groups = RowGroups(path, names)
    found = [len(groups.read(number, names)) for number in range(len(groups.sizes))]
    assert found == groups.sizes
    return f"{sum(found)} rows"


READS = [
    *((whole, name) for name in BOMBS),
    *((streamed, name) for name in ("names", "lying voxels")),
    (by_groups, "names"),
]


@pytest.fixture(scope="module")
def cost(tmp_path_factory):
    warm = tmp_path_factory.mktemp("warm") / "small.parquet"
    table(warm, 3)
    with measured(warm, SECONDS) as cost:
        yield cost


@pytest.mark.parametrize(("read", "name"), READS)
def test_bombs_are_refused_or_contained(cost, tmp_path, read, name):
    make, _, outcome = BOMBS[name]
    path = tmp_path / f"{name}.parquet"
    make(path)
    found = cost(read, path)
    assert re.search(outcome, found.outcome)
    assert found.own < 300 * MEGABYTE
    assert found.limited <= MEMORY
    assert found.seconds < SECONDS + SPARE


def test_many_short_texts_are_read(tmp_path):
    table(tmp_path / "grasps.parquet", 300_000, name="a" * 20)
    assert len(parquet.read(tmp_path / "grasps.parquet", SCHEMA)) == 300_000
    read = pd.concat(parquet.batches(tmp_path / "grasps.parquet", ["id", "x"]))
    assert read["id"].tolist() == ["a" * 20] * 300_000


def test_wide_values_are_read(tmp_path):
    kind = pa.binary(100_000_000)
    frame = pa.Table.from_arrays([pa.nulls(1, kind)], ["a"])
    pq.write_table(frame, tmp_path / "a.parquet", store_schema=False)
    assert len(parquet.read(tmp_path / "a.parquet", pa.schema([("a", kind)]))) == 1


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"data_page_version": "2.0"},
        {"row_group_size": 999},
        {"compression": "none"},
        {"use_dictionary": False, "write_page_index": True, "data_page_size": 1000},
        {"use_dictionary": ["a", "c"], "column_encoding": {"b": "DELTA_BYTE_ARRAY"}},
    ],
)
def test_tables_of_other_programs_are_read_however_they_are_packed(tmp_path, options):
    frame = pd.DataFrame(
        {
            "a": np.arange(50_000),
            "b": [str(k % 99) for k in range(50_000)],
            "c": [[str(k), "x"] for k in range(50_000)],
            "d": [None, 1.5] * 25_000,
        }
    )
    path = tmp_path / "a.parquet"
    written = pa.Table.from_pandas(frame)
    pq.write_table(written, path, **options)
    read = parquet.read(path, written.schema)
    assert pa.Table.from_pandas(read).equals(written)
    groups = RowGroups(path, ["b", "d"])
    parts = [groups.read(number, ["b", "d"]) for number in range(len(groups.sizes))]
    assert pd.concat(parts, ignore_index=True).equals(read[["b", "d"]])
    streamed = pd.concat(parquet.batches(path, ["b", "d"]), ignore_index=True)
    assert streamed.equals(read[["b", "d"]])


@pytest.mark.parametrize("name", ["../a", "/etc/a", "..", ".", "a\\b", "a\0b", "a/b"])
def test_labels_that_are_paths_are_refused(tmp_path, name):
    path = tmp_path / "names.parquet"
    pd.DataFrame({"id": ["some/object"], "label": [name]}).to_parquet(path)
    with pytest.raises(TableError, match="is not a valid file name"):
        parquet.read(path, pa.schema([ID, LABEL]))
    with pytest.raises(TableError, match="is not a valid file name"):
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
        write_meshes(tmp_path / "archive.parquet", tmp_path / "made/meshes", Settings().shape)
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
SOME = settings(MANY, max_examples=80, derandomize=True)
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
    """The same of a table that has no seal."""
    path, whole = archive
    path.write_bytes(whole)
    pq.write_table(pq.read_table(path).replace_schema_metadata(), path)
    return path, path.read_bytes()


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
    for place in range(footer, whole.index(b"egad-seal", footer), 50):  # the rest is the seal
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


@SOME
@given(changes())
def test_damaged_tables_without_a_seal_are_tables_or_refused(stranger, change):
    read_or_refuse(*stranger, change)


@pytest.mark.slow
@MANY
@given(changes())
def test_very_many_damaged_tables_without_a_seal_are_tables_or_refused(stranger, change):
    read_or_refuse(*stranger, change)


def test_damaged_statistics_of_a_table_without_a_seal_are_read_or_refused(stranger):
    path, bare = stranger
    footer = len(bare) - 8 - int.from_bytes(bare[-8:-4], "little")
    for place in range(footer, len(bare) - 8, 50):
        damaged = bytearray(bare)
        damaged[place] ^= 2
        path.write_bytes(damaged)
        read_all(path)


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
