"""Sums of the files of a folder, for `sha256sum --check SHA256SUMS`."""

import hashlib
from pathlib import Path

from egad.files import write_text

NAME = "SHA256SUMS"


def write_sums(folder: Path) -> None:
    """Write the SHA-256 sums of all files of a folder, also of those in its folders, into it."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    lines = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.relative_to(folder).as_posix()}\n"
        for path in files
        if path != folder / NAME
    ]
    write_text(folder / NAME, "".join(lines))
