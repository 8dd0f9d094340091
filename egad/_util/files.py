"""Writing files so that every file that exists is complete."""

import errno
import fcntl
import os
import secrets
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from egad.errors import UserError

OF_DISKS = (errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EROFS, errno.EFBIG)


def as_path(name: str, given: object) -> Path:
    """The argument of a public function that names a file or folder; otherwise `UserError`."""
    if not isinstance(given, str | os.PathLike):
        raise UserError(f"{name} is {given!r}; allowed: a path")
    return Path(given)


@contextmanager
def atomic_output(path: Path, keep: bool = True) -> Iterator[Path]:
    """Give a temporary path; on success it replaces `path`, a file or folder, which else stays.

    The output of a block that fails is kept until the next attempt, unless it is large: it may
    have filled the disk. `UserError` if another process is writing it.
    """
    path = path.absolute()
    check_writable(path)
    if path.is_mount():
        raise UserError(f"{path} is the root of a disk and cannot be replaced; name a folder in it")
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary, old = (path.with_name(f".{path.name}.{kind}") for kind in ("partial", "old"))
    with _alone(path):
        _remove(temporary)
        try:
            yield temporary
        except BaseException as error:
            if not keep:
                _remove(temporary)
            if (
                isinstance(error, OSError)
                and error.errno in OF_DISKS
                and (error.filename is None or str(error.filename).startswith(str(temporary)))
            ):
                raise UserError(f"{path} cannot be written: {error.strerror or error}") from error
            raise
        _remove(old)
        if temporary.is_dir() and path.exists():
            os.replace(path, old)  # a folder cannot be renamed onto another
        os.replace(temporary, path)
        _remove(old)


def check_writable(path: Path) -> None:
    """Raise `UserError` with the reason if no file can be written in the folder around a path."""
    parents = path.absolute().parents
    around = path if path.is_dir() else next(folder for folder in parents if folder.exists())
    try:
        tempfile.TemporaryFile(dir=around).close()
    except OSError as error:
        raise UserError(f"{path} cannot be written: {error.strerror or error}") from error


@contextmanager
def _alone(path: Path) -> Iterator[None]:
    """Keep other processes from writing a path. A lock left by a killed process does not."""
    lock = path.with_name(f".{path.name}.lock")
    with lock.open("a") as file:
        try:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # Else its owner has just removed it. Some file systems change inode numbers, and to
            # open the lock again would end it, so it is recognised by a size of its own.
            size = secrets.randbelow(1 << 20) + 1
            file.truncate(size)
            free = lock.stat().st_size == size
        except (BlockingIOError, PermissionError, FileNotFoundError):
            free = False
        except OSError:
            free = True  # the file system has no locks
        if not free:
            raise UserError(f"{path}: another process is writing it; wait for it, or stop it")
        try:
            yield
        finally:
            lock.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically."""
    with atomic_output(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
