"""Remove from an environment what no run reads: a quarter of it, nearly all of PyBullet.

    .venv/bin/python envs/trim.py

These are the example robots and pictures of PyBullet, its drawing on graphics cards, the debug
information of its code, the headers and static libraries that libigl brings along, and the tests of
packages that come with large ones.
"""

import os
import shutil
import struct
import sysconfig
from collections.abc import Iterable
from pathlib import Path

UNUSED = (
    *("include", "lib64", "share", "pybullet_envs", "eglRenderer*.so", "pybullet_data/*"),
    *("numpy/**/tests", "pandas/tests", "scipy/**/tests"),
)
USED = ("pybullet_data/__init__.py", "pybullet_data/franka_panda", "pybullet_data/__pycache__")
WITH_DEBUG = ("pybullet*.so",)
# The start of an ELF file of 64 bits, least byte first.
MAGIC = b"\x7fELF\x02\x01"
# Places in its header: where the table of segments starts, how long an entry of it is and how many
# there are; the same of sections, which only debuggers and linkers read.
SEGMENTS, SEGMENT_SIZE_AND_COUNT, SECTIONS, SECTION_COUNTS = 32, 54, 40, 60


def main() -> None:
    """Trim the environment of the Python that runs this."""
    trim(Path(sysconfig.get_path("platlib")))


def trim(packages: Path) -> None:
    """Remove what no run reads.

    Args:
        packages: The folder of installed packages.
    """
    used = set(_matching(packages, USED))
    for path in _matching(packages, UNUSED):
        if path not in used:
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    for path in _matching(packages, WITH_DEBUG):
        other = path.with_name(path.name + ".part")
        other.write_bytes(loadable_part(path.read_bytes()))
        shutil.copymode(path, other)
        os.replace(other, path)  # a link to it, as of a cache, stays whole


def loadable_part(library: bytes) -> bytes:
    """A shared library without what follows the part that is loaded: debug information, symbols.

    Args:
        library: Its bytes; those of another format than 64-bit ELF come back as they are.
    """
    if not library.startswith(MAGIC):
        return library
    (table,) = struct.unpack_from("<Q", library, SEGMENTS)
    size, count = struct.unpack_from("<HH", library, SEGMENT_SIZE_AND_COUNT)
    end = table + size * count
    for entry in range(table, end, size):
        offset, _, _, length = struct.unpack_from("<4Q", library, entry + 8)
        end = max(end, offset + length)
    shorter = bytearray(library[:end])
    struct.pack_into("<Q", shorter, SECTIONS, 0)
    struct.pack_into("<HH", shorter, SECTION_COUNTS, 0, 0)
    return bytes(shorter)


def _matching(packages: Path, patterns: Iterable[str]) -> Iterable[Path]:
    return [path for pattern in patterns for path in packages.glob(pattern)]


if __name__ == "__main__":
    main()
