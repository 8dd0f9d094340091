"""Folders that appear only when they are complete, and replace nothing."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from egad._util.files import atomic_output
from egad.errors import UserError


@contextmanager
def new_folder(path: Path) -> Iterator[Path]:
    """A folder to fill, which appears only at the end; `UserError` if there are files already."""
    check_not_file(path)
    if path.is_dir() and any(path.iterdir()):
        raise UserError(f"{path} is not empty, and its files would be lost; name a new folder")
    with atomic_output(path, keep=False) as folder:
        folder.mkdir()
        yield folder


def check_not_file(folder: Path) -> None:
    """Raise `UserError` if the path of a folder is a file."""
    if folder.is_file():
        raise UserError(f"{folder} is a file; name a folder")
