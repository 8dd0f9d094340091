import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from egad._util.files import atomic_output, check_writable, write_text
from egad.errors import UserError


def test_a_failed_write_leaves_the_old_file_and_the_temporary(tmp_path):
    path = tmp_path / "deep" / "file.txt"
    write_text(path, "old")
    with (
        pytest.raises(UserError, match=r"file\.txt cannot be written: No space left on device"),
        atomic_output(path) as temporary,
    ):
        temporary.write_text("half")
        raise OSError(28, "No space left on device")
    assert path.read_text() == "old"
    assert temporary.read_text() == "half"
    write_text(path, "new")
    assert path.read_text() == "new"
    assert [entry.name for entry in path.parent.iterdir()] == ["file.txt"]


WRITES = """
import sys
from pathlib import Path
from egad._util.files import atomic_output

with atomic_output(Path(sys.argv[1])) as temporary:
    temporary.write_text("theirs")
    print("writing", flush=True)
    sys.stdin.read()
"""


@pytest.mark.parametrize("killed", [False, True])
def test_only_one_process_writes_a_path_until_it_is_done_or_killed(tmp_path, killed):
    path, pipe = tmp_path / "file.txt", subprocess.PIPE
    command = [sys.executable, "-c", WRITES, str(path)]
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as other:
        other.stdout.readline()
        with pytest.raises(UserError, match="another process is writing it"):
            write_text(path, "ours")
        if killed:
            other.kill()
    assert path.exists() != killed
    write_text(path, "ours")
    assert path.read_text() == "ours"
    assert [entry.name for entry in tmp_path.iterdir()] == ["file.txt"]


def test_a_failed_write_need_not_leave_the_temporary(tmp_path):
    for make in (Path.touch, Path.mkdir):
        with (
            pytest.raises(UserError, match="full"),
            atomic_output(tmp_path / "a", keep=False) as temporary,
        ):
            make(temporary)
            raise OSError(errno.ENOSPC, "full")
        assert list(tmp_path.iterdir()) == []


def test_a_folder_replaces_a_folder(tmp_path):
    path = tmp_path / "meshes"
    for names in (["a", "b"], ["c"]):
        with atomic_output(path) as folder:
            folder.mkdir()
            for name in names:
                (folder / name).touch()
    assert [entry.name for entry in path.iterdir()] == ["c"]


def test_a_folder_is_never_missing_while_it_is_replaced(tmp_path):
    path = tmp_path / "meshes"
    with atomic_output(path) as folder:
        folder.mkdir()
        (folder / "old").touch()
    with atomic_output(path) as folder:
        folder.mkdir()
        assert (path / "old").exists()
    assert [entry.name for entry in tmp_path.iterdir()] == ["meshes"]


def test_a_lock_that_was_removed_while_it_was_taken_is_none(tmp_path, monkeypatch):
    """Another process finished between the opening of its lock and the locking of it."""
    lock = tmp_path / ".file.txt.lock"

    def late(*_arguments):
        lock.unlink()

    monkeypatch.setattr("egad._util.files.fcntl.lockf", late)
    with pytest.raises(UserError, match="another process is writing it"):
        write_text(tmp_path / "file.txt", "words")


def test_what_fails_otherwise_is_not_taken_for_a_full_disk(tmp_path):
    with pytest.raises(OSError, match="cannot identify"), atomic_output(tmp_path / "file.txt"):
        raise OSError("cannot identify image file")


def test_a_lock_is_recognised_where_inode_numbers_change(tmp_path, monkeypatch):
    """Some network file systems give a path another number than its open file."""
    real = os.fstat

    def other_number(file):
        values = list(real(file))
        values[1] += 1
        return os.stat_result(values)

    monkeypatch.setattr("egad._util.files.os.fstat", other_number)
    for text in ("one", "two"):
        write_text(tmp_path / "file.txt", text)
        assert (tmp_path / "file.txt").read_text() == text
    assert [entry.name for entry in tmp_path.iterdir()] == ["file.txt"]


@pytest.mark.parametrize("name", ["m.csv", "new/deep/m.csv"])
def test_a_file_of_a_read_only_disk_is_named_before_the_work(name):
    """As a file below /proc, where nobody can make one."""
    path = Path("/proc") / name
    for refuse in (check_writable, lambda path: atomic_output(path).__enter__()):
        with pytest.raises(UserError, match=rf"^/proc/{name} cannot be written: "):
            refuse(path)


def test_an_error_names_the_file_and_not_the_temporary_one(tmp_path):
    path = tmp_path / "m.csv"
    with (
        pytest.raises(UserError, match=rf"^{path} cannot be written: full"),
        atomic_output(path) as p,
    ):
        raise OSError(errno.ENOSPC, "full", str(p / "deep"))


def test_the_root_of_a_disk_is_not_replaced():
    with pytest.raises(UserError, match="shm is the root of a disk"):
        write_text(Path("/dev/shm"), "words")  # noqa: S108 (nothing is written)
