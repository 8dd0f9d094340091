"""join: the tables of all shards become one."""

from pathlib import Path

from egad import tables
from egad.errors import UserError
from egad.stages.shards import join

ORDERS = {
    "grasps": (tables.GRASPS, ["label", "grasp"]),
    "trials": (tables.TRIALS, ["label", "attempt"]),
    "history": (tables.HISTORY, ["epoch", "island", "step"]),
    "rejected": (tables.REJECTED, ["id", "stage"]),
}


def run(schema: str, parts: list[Path], out: Path) -> None:
    """Join tables of one schema, sorted so that the number of shards leaves no trace."""
    if schema not in ORDERS:
        raise UserError(f"--schema is {schema!r}; allowed: {', '.join(ORDERS)}")
    columns, order = ORDERS[schema]
    tables.write(join(parts, columns, order), columns, out)
