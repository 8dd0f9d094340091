"""join: the tables of all shards become one."""

from pathlib import Path

from egad._util.progress import phase
from egad.pipeline.stages.shards import join
from egad.tables import parquet


def run(parts: list[Path], order: list[str], out: Path) -> None:
    """Join tables that have the same columns.

    Args:
        parts: At least one table.
        order: Columns to sort by, so that the number of shards leaves no trace.
        out: The joined table.
    """
    phase(f"joining {len(parts)} tables")
    schema = parquet.schema_of(parts[0]).remove_metadata()
    parquet.write(join(parts, schema, order), schema, out)
