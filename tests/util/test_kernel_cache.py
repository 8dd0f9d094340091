import os
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from egad._util import kernel_cache
from egad._util.kernel_cache import (
    compile_kernels,
    compiled_marker,
    kernel_sources_version,
    use_own_cache,
)

KERNEL = "import numba\n\n@numba.njit(cache=True)\ndef double(x):\n    return {} * x\n"


def test_an_edited_kernel_changes_the_version_and_other_edits_do_not(tmp_path):
    (tmp_path / "kernels.py").write_text(KERNEL.format(2))
    (tmp_path / "other.py").write_text("a = 1\n")
    before = kernel_sources_version(tmp_path)
    (tmp_path / "other.py").write_text("a = 2\n")
    assert kernel_sources_version(tmp_path) == before
    (tmp_path / "kernels.py").write_text(KERNEL.format(3))
    assert kernel_sources_version(tmp_path) != before


def test_numba_uses_the_folder_unless_the_user_names_one():
    code = "import egad, numba; print(numba.config.CACHE_DIR)"

    def folder(**environment):
        inherited = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
        run = subprocess.run(
            [sys.executable, "-c", code],
            env=inherited | environment,
            capture_output=True,
            text=True,
            check=True,
        )
        return run.stdout.strip()

    assert folder().endswith(f"kernels-{kernel_sources_version()}")
    assert folder(NUMBA_CACHE_DIR="mine") == "mine"


def test_code_that_checks_its_indices_has_a_cache_of_its_own(monkeypatch):
    folders = []
    for checked in ("0", "1"):
        monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
        monkeypatch.setenv("NUMBA_BOUNDSCHECK", checked)
        use_own_cache()
        folders.append(os.environ["NUMBA_CACHE_DIR"])
    assert folders[0] != folders[1]


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


def kernel_folder(package):
    """Where kernels of a package are kept; one can write there."""
    use_own_cache(package)
    folder = Path(os.environ.pop("NUMBA_CACHE_DIR"))
    (folder / "kernel.nbc").touch()
    return folder


def test_kernels_of_a_read_only_package_are_kept_in_the_cache_folder_of_the_user(
    read_only, tmp_path, monkeypatch
):
    home = kernel_folder(read_only)
    assert home.is_relative_to(tmp_path / "home/.cache/egad")
    assert kernel_folder(read_only) == home
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "mine"))
    assert kernel_folder(read_only).is_relative_to(tmp_path / "mine/egad")


def test_without_a_writable_home_kernels_are_kept_in_a_temporary_folder_of_this_user(
    read_only, tmp_path
):
    (tmp_path / "home").touch()
    folder = kernel_folder(read_only)
    assert folder.is_relative_to(tmp_path)
    assert kernel_folder(read_only) == folder
    assert stat.S_IMODE(folder.parent.stat().st_mode) == 0o700


def test_kernels_are_not_kept_where_others_can_write(read_only, tmp_path):
    """They are loaded as machine code."""
    (tmp_path / "home").touch()
    open_to_all = kernel_folder(read_only).parent
    open_to_all.chmod(0o777)
    assert not kernel_folder(read_only).is_relative_to(open_to_all)


def test_kernels_are_compiled_once_for_each_state_of_their_sources(tmp_path, monkeypatch, capsys):
    started, status = [], 1

    def run(command, **_):
        started.append(command)
        return subprocess.CompletedProcess(command, status)

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(kernel_cache.subprocess, "run", run)
    compile_kernels()
    assert "compiled at their first use" in capsys.readouterr().err
    started.clear()
    status = 0
    compile_kernels()
    compiled_marker().touch()
    compile_kernels()
    assert len(started) == 1
    monkeypatch.setattr(kernel_cache, "kernel_sources_version", lambda: "edited")
    compile_kernels()
    assert len(started) == 2
