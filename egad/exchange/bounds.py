"""How much is read of files of strangers."""

from egad.errors import RejectedError

MOST_BYTES = 1 << 30  # of a file
MOST_ITEMS = 4_000_000  # vertices, and as many faces
MOST_PARTS = 10_000  # bodies, nodes, instances
MOST_CORNERS = 10_000  # of a polygon
MOST_UNPACKED = 1 << 28  # bytes of all that is in a zip, and of the structure of a GLB file


def within(count: float, most: int, what: str) -> None:
    """Refuse more of something than is read.

    Raises:
        RejectedError: There is more, or less than none.
    """
    if not 0 <= count <= most:
        raise RejectedError(f"{count:,.0f} {what}; from 0 to {most:,} are read")
