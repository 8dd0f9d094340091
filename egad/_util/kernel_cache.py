"""The cache of compiled kernels: a separate folder for each version of their sources.

numba looks only at the file of a kernel when it decides whether its cached machine code is still
good, not at the kernels of other files that were compiled into it. After an edit or an update it
would run stale code with new data. Nor does it consider whether the code checks its indices.
"""

import hashlib
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def kernel_sources_version(package: Path = PACKAGE) -> str:
    """A fingerprint of all source files of the package that hold kernels."""
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        text = path.read_bytes()
        if b"\n@kernel(" in text:
            digest.update(path.name.encode() + text)
    return digest.hexdigest()[:16]


@cache
def kernel_folder(package: Path = PACKAGE) -> Path:
    """The folder for compiled kernels: the first of `_parents` to be writable, or temporary."""
    checked = "-bounds" if os.environ.get("NUMBA_BOUNDSCHECK", "0") != "0" else ""
    name = f"kernels-{kernel_sources_version(package)}{checked}"
    folders = (parent / name for parent in _parents(package))
    found = next((folder for folder in folders if _can_write(folder)), None)
    return found or Path(tempfile.mkdtemp(prefix="egad-"))


def compiled_marker() -> Path:
    """A file that exists if all kernels were compiled for this processor, Python and numba."""
    from llvmlite.binding import get_host_cpu_name  # noqa: PLC0415 (only runs and setup need it)

    made_for = (sys.implementation.cache_tag, version("numba"), get_host_cpu_name())
    name = "-".join(["compiled", kernel_sources_version(), *map(str, made_for)])
    return kernel_folder() / name


def _parents(package: Path) -> Iterator[Path]:
    """Folders to keep kernels in, the preferred one first."""
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(given)
    yield package / "__pycache__"
    with suppress(RuntimeError):  # there is no home
        yield Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser() / "egad"
    temporary = Path(tempfile.gettempdir()) / f"egad-{os.getuid()}"
    if _is_private(temporary):
        yield temporary


def _is_private(folder: Path) -> bool:
    """Make a folder; returns whether only this user can write to it: the code in it is run."""
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
    except OSError:
        return False
    return status.st_uid == os.getuid() and not status.st_mode & 0o022


def _can_write(folder: Path) -> bool:
    """Make a folder with its parents; returns whether files can be made in it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)
