"""Hashes of files other than tables, stored beside them, for `sha256sum --check`.

A folder has them in `SHA256SUMS`, a file `NAME` in `NAME.sha256`. The first line, a comment to
other programs, says where the files come from (`egad.tables.origin`).
"""

import hashlib
import json
from pathlib import Path, PurePosixPath
from typing import Any

from egad._util.files import write_text
from egad.errors import UserError
from egad.io.folders import files_below
from egad.tables import origin

SUMS, SUMS_ENDING = "SHA256SUMS", ".sha256"
_ORIGIN = "# egad-origin "
MAX_BYTES = 1 << 26  # of a file of sums: about half a million lines


def checksum(path: Path) -> str:
    """The SHA-256 of a file; that of its `SHA256SUMS` for a folder, made if there is none."""
    if not path.is_dir():
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    if (path / SUMS).is_file():
        return checksum(path / SUMS)
    return hashlib.sha256(_lines(path, files_of(path)).encode()).hexdigest()


def files_of(folder: Path) -> list[Path]:
    """All files of `files_below`, except hidden ones and the `SHA256SUMS` of the folder."""
    files = (path for path in files_below(folder) if path.is_file() and path != folder / SUMS)
    return sorted(path for path in files if not path.name.startswith("."))


def sums_path(path: Path) -> Path:
    """Where the sums of a file or folder are."""
    return path / SUMS if path.is_dir() else path.with_name(path.name + SUMS_ENDING)


def write_sums(path: Path) -> None:
    """Write the sum of a file, or those of all files of a folder and of the folders in it."""
    folder, files = (path, files_of(path)) if path.is_dir() else (path.parent, [path])
    made = origin.noted(folder)
    head = f"{_ORIGIN}{json.dumps(made, sort_keys=True)}\n" if made else ""
    write_text(sums_path(path), head + _lines(folder, files))


def read_sums(path: Path) -> tuple[dict[Path, str], dict[str, Any]]:
    """The sums of listed files, and their origin; `UserError` if damaged or outside the folder."""
    if path.stat().st_size > MAX_BYTES:
        raise UserError(f"{path}: not a checksum file (larger than {MAX_BYTES:,} bytes)")
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
        made = [json.loads(line[len(_ORIGIN) :]) for line in lines if line.startswith(_ORIGIN)]
        pairs = [line.split("  ", 1) for line in lines if not line.startswith("#")]
        sums = {path.parent / _inside(name): value for value, name in pairs}
        return sums, dict(made[0] if made else {})
    except (ValueError, TypeError, RecursionError) as error:
        raise UserError(f"{path}: not a checksum file ({error})") from error


def missing_files(folder: Path) -> list[Path]:
    """The files that `SHA256SUMS` lists and that are not there; none without a readable list."""
    try:
        return [path for path in read_sums(folder / SUMS)[0] if not path.is_file()]
    except (UserError, OSError):
        return []


def _inside(name: str) -> str:
    """Return the name of a file unless it leads out of its folder."""
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or "\0" in name:
        raise ValueError(f"{name!r} is outside of its folder")
    return name


def _lines(folder: Path, files: list[Path]) -> str:
    return "".join(f"{checksum(file)}  {file.relative_to(folder).as_posix()}\n" for file in files)
