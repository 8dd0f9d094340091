"""Whether a file can be written, before any work."""

from pathlib import Path

from egad._util.files import check_writable
from egad.errors import UserError

ENDINGS = (".parquet", ".csv")


def check_ending(path: Path | None, endings: tuple[str, ...] = ENDINGS) -> None:
    """Raise `UserError`, before any work, if a table cannot be written or has another ending."""
    if path is None:
        return
    if path.suffix.lower() not in endings:
        raise UserError(f"--out {path}: the name must end in {' or '.join(endings)}")
    if path.is_dir():
        raise UserError(f"--out {path} is a folder; name a file")
    if not path.absolute().parent.is_dir():
        raise UserError(f"--out {path}: there is no folder {path.parent}")
    check_writable(path)
