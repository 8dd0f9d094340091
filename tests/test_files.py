from pathlib import Path

import pytest

from egad.files import replacing, write_text


def test_a_failed_write_leaves_the_old_file_and_the_temporary(tmp_path):
    path = tmp_path / "deep" / "file.txt"
    write_text(path, "old")
    with pytest.raises(OSError, match="No space left"), replacing(path) as temporary:
        temporary.write_text("half")
        raise OSError(28, "No space left on device")
    assert path.read_text() == "old"
    assert temporary.read_text() == "half"
    write_text(path, "new")
    assert path.read_text() == "new"
    assert [entry.name for entry in path.parent.iterdir()] == ["file.txt"]


def test_a_failed_write_need_not_leave_the_temporary(tmp_path):
    for make in (Path.touch, Path.mkdir):
        with (
            pytest.raises(OSError, match="full"),
            replacing(tmp_path / "a", keep=False) as temporary,
        ):
            make(temporary)
            raise OSError("full")
        assert list(tmp_path.iterdir()) == []


def test_a_folder_replaces_a_folder(tmp_path):
    path = tmp_path / "meshes"
    for names in (["a", "b"], ["c"]):
        with replacing(path) as folder:
            folder.mkdir()
            for name in names:
                (folder / name).touch()
    assert [entry.name for entry in path.iterdir()] == ["c"]


def test_a_failed_folder_leaves_the_old_one(tmp_path):
    path = tmp_path / "meshes"
    with replacing(path) as folder:
        folder.mkdir()
    with pytest.raises(RuntimeError), replacing(path) as folder:
        folder.mkdir()
        raise RuntimeError
    assert list(path.iterdir()) == []
    assert folder.exists()


def test_a_folder_is_never_missing_while_it_is_replaced(tmp_path):
    path = tmp_path / "meshes"
    with replacing(path) as folder:
        folder.mkdir()
        (folder / "old").touch()
    with replacing(path) as folder:
        folder.mkdir()
        assert (path / "old").exists()
    assert [entry.name for entry in tmp_path.iterdir()] == ["meshes"]
