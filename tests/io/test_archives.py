"""ZIP archives: others read what was packed, and only contents decide their bytes."""

import os
import subprocess
import sys
import zipfile

from egad.io.folders import write_zip


def folder_with(path, texts, time):
    for name, text in texts.items():
        (path / name).parent.mkdir(parents=True, exist_ok=True)
        (path / name).write_text(text)
        (path / name).chmod(0o600)
        os.utime(path / name, (time, time))
    return path


def test_the_same_files_give_the_same_bytes(tmp_path):
    texts = {"A0/b.txt": "b", "A0/a.txt": "a" * 1000}
    first = folder_with(tmp_path / "first", texts, 1e9)
    second = folder_with(tmp_path / "second", dict(reversed(texts.items())), 1.5e9)
    (second / "A0/a.txt").chmod(0o755)
    for name, folder in (("1.zip", first), ("2.zip", second)):
        write_zip(tmp_path / name, [folder])
    assert (tmp_path / "1.zip").read_bytes() == (tmp_path / "2.zip").read_bytes()


def test_others_unpack_it(tmp_path):
    folders = [
        folder_with(tmp_path / name, {f"{name}/{name}.urdf": name}, 1e9) for name in ("B1", "A0")
    ]
    write_zip(tmp_path / "all.zip", folders)
    with zipfile.ZipFile(tmp_path / "all.zip") as archive:
        assert archive.testzip() is None
        assert archive.namelist() == ["B1/B1.urdf", "A0/A0.urdf"]
    out = tmp_path / "out"
    subprocess.run(
        [sys.executable, "-m", "zipfile", "-e", "all.zip", out], cwd=tmp_path, check=True
    )
    assert (out / "A0/A0.urdf").read_text() == "A0"


def test_linked_folders_are_packed(tmp_path):
    folder_with(tmp_path / "kept", {"deep/a.txt": "a"}, 1e9)
    folder = folder_with(tmp_path / "folder", {"b.txt": "b"}, 1e9)
    (folder / "linked").symlink_to(tmp_path / "kept")
    (folder / "round").symlink_to(folder)
    write_zip(tmp_path / "1.zip", [folder])
    with zipfile.ZipFile(tmp_path / "1.zip") as archive:
        assert archive.namelist() == ["b.txt", "linked/deep/a.txt"]
        assert archive.read("linked/deep/a.txt") == b"a"
