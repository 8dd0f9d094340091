import os
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from egad._util import kernel_cache
from egad._util.kernel_cache import (
    kernel_folder,
    kernel_sources_version,
)

KERNEL = "from egad._util.kernels import kernel\n\n@kernel()\ndef double(x):\n    return {} * x\n"


def test_an_edited_kernel_changes_the_version_and_other_edits_do_not(tmp_path):
    (tmp_path / "kernels.py").write_text(KERNEL.format(2))
    (tmp_path / "other.py").write_text("a = 1\n")
    before = kernel_sources_version(tmp_path)
    (tmp_path / "other.py").write_text("a = 2\n")
    assert kernel_sources_version(tmp_path) == before
    (tmp_path / "kernels.py").write_text(KERNEL.format(3))
    assert kernel_sources_version(tmp_path) != before


def test_a_folder_that_the_user_names_has_one_for_each_state_of_the_sources(tmp_path, monkeypatch):
    """In one folder for all, an update would run stale code."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    folder = kernel_folder.__wrapped__()
    assert folder == tmp_path / f"kernels-{kernel_sources_version()}"


def test_kernels_of_others_go_where_numba_puts_them(tmp_path):
    """Whether they were defined before ours or after."""
    (tmp_path / "theirs.py").write_text(
        "import numba\n\n@numba.njit(cache=True)\ndef theirs(x):\n    return 2 * x\n"
    )
    code = """
import os, numba, egad
from egad.geometry.refinement import triangulation  # has kernels
from egad.geometry import refinement
from theirs import theirs
theirs(1)
ours = next(value for value in vars(refinement).values() if hasattr(value, "py_func"))
print(theirs.stats.cache_path, ours.stats.cache_path, numba.config.CACHE_DIR, sep="\\n")
assert "NUMBA_CACHE_DIR" not in os.environ
"""
    environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    run = subprocess.run(
        [sys.executable, "-c", code],
        env=environment | {"PYTHONPATH": os.pathsep.join([*sys.path, str(tmp_path)])},
        capture_output=True,
        text=True,
        check=True,
    )
    theirs, ours, wanted, *_ = run.stdout.split("\n")
    assert Path(theirs) == tmp_path / "__pycache__"
    assert list(Path(theirs).glob("theirs.theirs*.nbi"))
    assert Path(ours).parent.name == f"kernels-{kernel_sources_version()}"
    assert wanted == ""


def test_code_that_checks_its_indices_has_a_cache_of_its_own(monkeypatch):
    folders = []
    for checked in ("0", "1"):
        monkeypatch.setenv("NUMBA_BOUNDSCHECK", checked)
        folders.append(kernel_folder.__wrapped__())
    assert folders[0] != folders[1]


def test_every_kernel_of_ours_is_kept_there():
    """Other decorators would keep it where numba does not see an edit of a kernel that it calls."""
    decorated = [
        path.name for path in kernel_cache.PACKAGE.rglob("*.py") if "@numba." in path.read_text()
    ]
    assert decorated == []


@pytest.fixture
def read_only(tmp_path, monkeypatch):
    """A package whose folder takes no new folder, on a machine with a home and temporary files."""
    package = tmp_path / "package"
    package.mkdir()
    (package / "__pycache__").touch()
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return package


def writable_folder(package):
    """Where kernels of a package are kept; one can write there."""
    folder = kernel_folder.__wrapped__(package)
    (folder / "kernel.nbc").touch()
    return folder


def test_kernels_of_a_read_only_package_are_kept_in_the_cache_folder_of_the_user(
    read_only, tmp_path, monkeypatch
):
    home = writable_folder(read_only)
    assert home.is_relative_to(tmp_path / "home/.cache/egad")
    assert writable_folder(read_only) == home
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "mine"))
    assert writable_folder(read_only).is_relative_to(tmp_path / "mine/egad")


def test_without_a_writable_home_kernels_are_kept_in_a_temporary_folder_of_this_user(
    read_only, tmp_path
):
    (tmp_path / "home").touch()
    folder = writable_folder(read_only)
    assert folder.is_relative_to(tmp_path)
    assert writable_folder(read_only) == folder
    assert stat.S_IMODE(folder.parent.stat().st_mode) == 0o700


def test_kernels_are_not_kept_where_others_can_write(read_only, tmp_path):
    """They are loaded as machine code."""
    (tmp_path / "home").touch()
    open_to_all = writable_folder(read_only).parent
    open_to_all.chmod(0o777)
    assert not writable_folder(read_only).is_relative_to(open_to_all)
