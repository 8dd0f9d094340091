import shutil
import subprocess
from pathlib import Path

import pytest

from egad.errors import UserError
from egad.io.sums import SUMS, checksum, files_of, missing_files, read_sums, write_sums
from egad.tables.origin import Origin, made_by


@pytest.fixture
def folder(tmp_path):
    made = tmp_path / "made"
    (made / "deep").mkdir(parents=True)
    (made / "a.obj").write_text("a")
    (made / "deep/b c.stl").write_text("b")
    (made / ".snakemake_timestamp").write_text("now")
    return made


def test_the_sums_of_a_folder_do_not_depend_on_hidden_files_or_on_being_written(folder):
    before = checksum(folder)
    write_sums(folder)
    assert checksum(folder) == before
    assert {path.name for path in read_sums(folder / SUMS)[0]} == {"a.obj", "b c.stl"}
    (folder / "a.obj").write_text("c")
    (folder / SUMS).unlink()
    assert checksum(folder) != before


@pytest.mark.skipif(shutil.which("sha256sum") is None, reason="needs sha256sum")
@pytest.mark.parametrize("made", [None, Origin("1.0", "rescale", "c0de")])
def test_other_programs_can_check_them(folder, made):
    (folder / "c.h5").write_text("c")
    with made_by(made):
        write_sums(folder / "c.h5")
        write_sums(folder)
    for name in (SUMS, "c.h5.sha256"):
        done = subprocess.run(
            ["sha256sum", "--check", "--strict", name], cwd=folder, capture_output=True, check=False
        )
        assert done.returncode == 0, done.stderr
    assert bool(read_sums(folder / SUMS)[1]) == bool(made)


@pytest.mark.parametrize(
    "text",
    [
        "not sums",
        "# egad-origin {\n",
        "# egad-origin 7\n",
        "\xff",
        "00  /etc/passwd",
        "00  ../a",
        f"# egad-origin {'[' * 100_000}\n",
    ],
)
def test_damaged_sums_are_named(folder, text):
    (folder / SUMS).write_bytes(text.encode("latin-1"))
    with pytest.raises(UserError, match="SHA256SUMS: not a checksum file"):
        read_sums(folder / SUMS)


def test_a_file_of_sums_without_end_is_not_read(folder):
    with (folder / SUMS).open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(UserError, match="larger than"):
        read_sums(folder / SUMS)


def test_missing_files_are_those_that_were_written_and_are_gone(folder):
    assert missing_files(folder) == []  # nothing was noted
    write_sums(folder)
    assert missing_files(folder) == []
    (folder / "a.obj").write_text("altered")
    (folder / "more.obj").write_text("added")
    assert missing_files(folder) == []
    (folder / "deep/b c.stl").unlink()
    assert missing_files(folder) == [folder / "deep/b c.stl"]
    (folder / SUMS).write_text("00  ../b\n")
    assert missing_files(folder) == []
    assert missing_files(folder / "gone") == []


@pytest.mark.parametrize("names", ["abc", "cba"])
def test_files_are_in_the_order_of_their_names_whatever_that_on_disk(tmp_path, monkeypatch, names):
    files = [tmp_path / name for name in names]
    for file in files:
        file.touch()
    monkeypatch.setattr(Path, "rglob", lambda *_: iter(files))
    assert files_of(tmp_path) == sorted(files)
