"""Writing files so that what exists is complete."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replacing(path: Path, keep: bool = True) -> Iterator[Path]:
    """Give a temporary path beside `path`; on success it takes the place of `path`.

    If the block fails, `path` is as it was before. A block may write a file or make a folder.

    Args:
        path: The file or folder.
        keep: Whether what a failed block has written stays for a look, until the next attempt
            replaces it. What is large should not: it may be what filled the disk.
    """
    path = path.absolute()
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.partial")
    _remove(temporary)
    try:
        yield temporary
    except BaseException:
        if not keep:
            _remove(temporary)
        raise
    old = path.with_name(f".{path.name}.old")
    _remove(old)
    if temporary.is_dir() and path.exists():
        os.replace(path, old)  # a folder cannot be renamed onto another
    os.replace(temporary, path)
    _remove(old)


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
