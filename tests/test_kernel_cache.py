import os
import subprocess
import sys

from egad.kernel_cache import kernel_sources_version, use_own_cache

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
