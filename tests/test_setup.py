"""What `make setup` does: `envs/install.py` and `envs/trim.py`."""

import importlib.util
import os
import shutil
import stat
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]


def script(name):
    """A script of `envs/` as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / f"envs/{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


install, trim = script("install"), script("trim")


def test_uv_takes_packages_from_where_pip_takes_them():
    listed = """\
:env:.index-url='https://mine.example/simple'
freeze.timeout='10'
global.cert='/etc/own.pem'
global.extra-index-url='\\nfile:///a/simple\\nfile:///b/simple'
global.find-links='/wheels /more'
global.index-url='https://theirs.example/simple'
install.cert='/etc/other.pem'
"""
    assert install.uv_settings(install.pip_settings(listed)) == {
        "UV_DEFAULT_INDEX": "https://mine.example/simple",
        "UV_INDEX": "file:///a/simple file:///b/simple",
        "UV_FIND_LINKS": "/wheels,/more",
        "SSL_CERT_FILE": "/etc/other.pem",
    }
    assert install.uv_settings(install.pip_settings("")) == {}


def test_no_python_has_to_compile_pybullet():
    """It has wheels up to Python 3.11 only; newer ones get along with MuJoCo."""
    lock = (ROOT / "requirements.lock").read_text()
    (line,) = (line for line in lock.splitlines() if line.startswith("pybullet=="))
    marker = Requirement(line.removesuffix(" \\")).marker
    assert marker is not None
    allowed = [marker.evaluate({"python_full_version": f"3.{minor}.0"}) for minor in range(11, 16)]
    assert allowed == [True, False, False, False, False]
    assert any(line.startswith("mujoco==") for line in lock.splitlines())


def test_a_lock_is_installed_without_what_another_lock_installed_before(tmp_path, monkeypatch):
    """uv refuses a package that another one asks for and that has no hash in this lock."""
    lock = tmp_path / "more.lock"
    lock.write_text("scikit-image==0.26.0 --hash=sha256:0")
    steps = []
    monkeypatch.setattr(sys, "argv", ["install.py", str(lock)])
    monkeypatch.setattr(install, "with_uv", steps.extend)
    monkeypatch.setattr(install, "with_pip", lambda _: None)
    install.main()
    assert {"--no-deps", "--require-hashes"} <= set(steps[0])


def test_trimming_leaves_what_is_used(tmp_path):
    for name in ("pybullet_utils/a.py", "numpy/include/a.h"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    kept = {path for path in tmp_path.rglob("*") if path.is_file()}
    for name in ("pybullet_data/toys/a.obj", "mujoco/studio/a.so", "include/a.h"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    trim.trim(tmp_path)
    assert {path for path in tmp_path.rglob("*") if path.is_file()} == kept


@pytest.mark.skipif(not shutil.which("objcopy"), reason="needs the GNU binutils")
def test_a_library_without_debug_information_still_loads(tmp_path):
    """One that another file is a link to stays as it was there."""
    (original,) = Path(sysconfig.get_path("platlib")).glob("manifold3d*.so")
    library = tmp_path / "pybullet.so"
    shutil.copy2(original, library)
    debug = tmp_path / "debug"
    debug.write_bytes(bytes(1_000_000))
    option = f"--add-section=.debug_info={debug}"
    subprocess.run(["objcopy", option, library], check=True)
    size = library.stat().st_size
    link = tmp_path / "cached"
    os.link(library, link)
    trim.trim(tmp_path)
    assert library.stat().st_size < size - 1_000_000
    assert link.stat().st_size == size
    assert library.stat().st_mode & stat.S_IXUSR
    shutil.copy2(library, tmp_path / original.name)
    code = "import manifold3d; print(manifold3d.__file__, manifold3d.Manifold.cube().volume())"
    said = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert said.split() == [str(tmp_path / original.name), "1.0"]
