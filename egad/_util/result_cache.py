"""A cache of slow results in the user's cache folder, keyed by what they are made of.

The folder is `EGAD_CACHE_DIR`, or else `egad` in `XDG_CACHE_HOME` or `~/.cache`;
`EGAD_CACHE_DIR=off` keeps nothing. Results are the same with and without the cache: the name of a
result is a digest of the input, the parameters, the code and the libraries that determine it.
Damaged results are computed again, and where nothing can be written nothing is kept.
"""

import hashlib
import os
import tempfile
import zipfile
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from egad._util.arithmetic import arithmetic
from egad.errors import UserError

PACKAGE = Path(__file__).parents[1]
FOLDER, OFF = "EGAD_CACHE_DIR", "off"
MAX_BYTES = 10**9  # of all results of a kind; the ones not used for longest are removed first
Arrays = dict[str, NDArray[Any]]


def cached(kind: str, given: Iterable[object], code: str, make: Callable[[], Arrays]) -> Arrays:
    """Arrays from the cache, or made and stored; `given` and a `source_version` decide."""
    folder = _folder()
    if folder is None:
        return make()
    path = folder / kind / f"{_digest([code, *given])}.npz"
    found = _read(path)
    if found is None:
        found = make()
        with suppress(OSError):
            _write(path, found)
    return found


@cache
def source_version(modules: tuple[str, ...], libraries: tuple[str, ...]) -> str:
    """A digest of files and folders of egad, of distributions, if any, and of `arithmetic`."""
    paths = [PACKAGE / name for name in modules]
    files = [file for path in paths for file in ([path] if path.is_file() else path.rglob("*.py"))]
    texts = [part for file in sorted(files) for part in (file.name, file.read_bytes())]
    return _digest([*texts, *map(_version, libraries), arithmetic()])


def _version(library: str) -> str:
    try:
        return version(library)
    except PackageNotFoundError:
        return "none"


def _digest(given: Iterable[object]) -> str:
    digest = hashlib.sha256()
    for each in given:
        kind, data = type(each).__name__, each if isinstance(each, bytes) else repr(each).encode()
        if isinstance(each, np.ndarray):
            kind, data = f"{each.dtype}{each.shape}", each.tobytes()
        digest.update(f"{kind} {len(data)}\n".encode() + data)
    return digest.hexdigest()


def _folder() -> Path | None:
    """Where results are kept; None if nowhere."""
    given = os.environ.get(FOLDER)
    if given == OFF:
        return None
    if given and not Path(given).is_absolute():
        raise UserError(f"{FOLDER} is {given!r}; allowed: an absolute path, or {OFF}")
    with suppress(RuntimeError):  # there is no home
        cache_home = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
        return Path(given) if given else cache_home / "egad"
    return None


def _read(path: Path) -> Arrays | None:
    """A result; None if there is none, or it is damaged."""
    try:
        with np.load(path, allow_pickle=False) as file:
            found = dict(file)
        os.utime(path)  # it was used
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    return found


def _write(path: Path, arrays: Arrays) -> None:
    """Write a result as a whole: another process may read or write the same one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".partial", delete=False) as file:
        try:
            np.savez(file, allow_pickle=False, **arrays)
            file.close()
            os.replace(file.name, path)
        except BaseException:
            Path(file.name).unlink(missing_ok=True)
            raise
    _remove_oldest(path.parent)


def _remove_oldest(folder: Path) -> None:
    files = []
    for entry in os.scandir(folder):
        with suppress(FileNotFoundError):  # another process removed it
            status = entry.stat()
            files.append((status.st_mtime, status.st_size, entry.path))
    spare = sum(size for _, size, _ in files) - MAX_BYTES
    for _, size, name in sorted(files):
        if spare <= 0:
            break
        Path(name).unlink(missing_ok=True)
        spare -= size
