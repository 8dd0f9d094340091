"""ZIP archives that have the same bytes whenever and wherever they are packed."""

import zipfile
from collections.abc import Iterable
from pathlib import Path

from egad.io.folders import files_below

EARLIEST = (1980, 1, 1, 0, 0, 0)  # the earliest time that a ZIP archive can hold
READABLE = 0o100644 << 16  # a plain file that everybody may read
UNIX = 3


def write_zip(path: Path, folders: Iterable[Path]) -> None:
    """Pack all files of folders, in this order, with the same times and permissions for all."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        for folder in folders:
            for file in sorted(each for each in files_below(folder) if each.is_file()):
                entry = zipfile.ZipInfo(file.relative_to(folder).as_posix(), EARLIEST)
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.create_system, entry.external_attr = UNIX, READABLE
                archive.writestr(entry, file.read_bytes())
