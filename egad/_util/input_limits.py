"""Limits on what is read of meshes and tables that other programs wrote."""

from egad.errors import RejectedError

MAX_MESH_BYTES = 1 << 30  # of a file
MAX_UNPACKED_BYTES = 1 << 28  # of everything in a zip
MAX_VERTICES = MAX_FACES = 4_000_000
MAX_DIRECT_BYTES = 1 << 23  # bytes of an OBJ file; parsing it takes up to 60 times as much memory

MAX_TABLE_BYTES = 4 << 30  # of a Parquet file, and of its columns unpacked
MAX_FOREIGN_TABLE_BYTES = 1 << 29  # in memory, of a table without a seal
MAX_ROWS = 50_000_000
MAX_COLUMNS = 1000

# Limits of the process that parses files that may unfold to any size, see `egad._util.limited`.
MAX_MEMORY = 4 << 30  # bytes
MAX_SECONDS = 600.0


def check_at_most(count: int, most: int, what: str) -> None:
    """Raise `RejectedError` for a file with more of something than is read."""
    if count > most:
        raise RejectedError(f"{count:,} {what}; at most {most:,} are read")
