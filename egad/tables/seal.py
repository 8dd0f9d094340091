"""The seal of a Parquet file: a hash of its own bytes in its footer, so that any change shows.

It is not a signature: anyone who changes a file on purpose can seal it again. Tables that were made
from the file still have its old hash, see `egad.tables.origin`.
"""

import hashlib
import mmap
from pathlib import Path

KEY, _MARK = "egad-seal", b"egad-seal:"
_DIGITS = 64
BLANK = (_MARK + b"0" * _DIGITS).decode()
_TAIL = 8  # bytes: the length of the footer, and a magic word


def seal(path: Path) -> None:
    """Fill in the seal of a file that was written with `BLANK` in its footer."""
    with path.open("r+b") as file, mmap.mmap(file.fileno(), 0) as data:
        place = _place(data)
        data[place : place + _DIGITS] = hashlib.sha256(data).hexdigest().encode()


def is_whole(path: Path) -> bool | None:
    """Whether a file is unchanged since it was sealed; None if it has no seal."""
    if path.stat().st_size < _TAIL:
        return None
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        place = _place(data)
        if place < 0:
            return None
        digest = hashlib.sha256()
        with memoryview(data) as view:
            for part in (view[:place], b"0" * _DIGITS, view[place + _DIGITS :]):
                digest.update(part)
                if isinstance(part, memoryview):
                    part.release()
        return data[place : place + _DIGITS] == digest.hexdigest().encode()


def _place(data: mmap.mmap) -> int:
    """Where the digits of the seal are; negative without one."""
    length = int.from_bytes(data[-_TAIL:-4], "little")
    found = data.rfind(_MARK, max(0, len(data) - _TAIL - length))
    return found + len(_MARK) if found >= 0 else -1
