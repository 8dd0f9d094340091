"""Remove from an environment what no run reads: a quarter of it, nearly all of PyBullet.

    .venv/bin/python envs/trim.py

These are the example robots and pictures of PyBullet, its drawing on graphics cards, the debug
information of its code (where there is a `strip` that can do so), the graphical programs of MuJoCo,
the headers and static libraries that libigl brings along, and the tests of numpy, scipy and pandas.
"""

import os
import shutil
import subprocess
import sysconfig
from collections.abc import Iterable
from pathlib import Path

UNUSED = (
    *("include", "lib64", "share", "pybullet_envs", "eglRenderer*.so", "pybullet_data"),
    *("mujoco/experimental", "mujoco/studio"),
    *("numpy/**/tests", "pandas/tests", "scipy/**/tests"),
)
WITH_DEBUG = ("pybullet*.so",)


def main() -> None:
    """Trim the environment of the Python that runs this."""
    trim(Path(sysconfig.get_path("platlib")))


def trim(packages: Path) -> None:
    """Remove what no run reads.

    Args:
        packages: The folder of installed packages.
    """
    for path in _matching(packages, UNUSED):
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    if program := shutil.which("strip"):
        for path in _matching(packages, WITH_DEBUG):
            other = path.with_name(path.name + ".part")
            # -S, as the strip of macOS knows no long options
            if subprocess.run([program, "-S", "-o", other, path], check=False).returncode:
                other.unlink(missing_ok=True)
            else:
                os.replace(other, path)  # a link to it, as of a cache, stays whole


def _matching(packages: Path, patterns: Iterable[str]) -> Iterable[Path]:
    return [path for pattern in patterns for path in packages.glob(pattern)]


if __name__ == "__main__":
    main()
