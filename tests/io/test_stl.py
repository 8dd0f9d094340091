"""STL files: which are binary, by their length."""

import pytest
import trimesh

from egad.io import count_binary_faces

BINARY = trimesh.creation.box().export(file_type="stl")
TEXT = trimesh.creation.box().export(file_type="stl_ascii")


@pytest.mark.parametrize(
    ("data", "count"),
    [
        (BINARY, 12),
        (b"solid part" + BINARY[10:], 12),
        (bytes(84), 0),
        (BINARY[:-1], None),
        (BINARY + b"\0", None),
        (BINARY[:83], None),
        (b"", None),
        (TEXT if isinstance(TEXT, bytes) else TEXT.encode(), None),
    ],
)
def test_faces_are_counted_in_binary_files_of_the_right_length(tmp_path, data, count):
    (tmp_path / "a.stl").write_bytes(data)
    assert count_binary_faces(tmp_path / "a.stl") == count
