"""join: combine the tables of all shards."""

from pathlib import Path
from typing import Annotated

import typer

from egad._util.progress import phase
from egad.pipeline.parameters import Input, Output, command
from egad.pipeline.stages.shards import join
from egad.tables import parquet


@command()
def run(
    parts: Annotated[list[Path], typer.Argument(), Input()],
    by: list[str],
    out: Annotated[Path, Output()],
) -> None:
    """Combine the tables of all shards into one.

    Args:
        parts: Tables with the same columns.
        by: Column to sort by, so that the result does not depend on the shards; may be repeated.
        out: The joined table.
    """
    phase(f"joining {len(parts)} tables")
    schema = parquet.schema_of(parts[0]).remove_metadata()
    parquet.write(join(parts, schema, by), schema, out)
