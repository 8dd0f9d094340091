"""join: combine the tables of all shards."""

from pathlib import Path

from egad._util.progress import phase
from egad.tables import parquet
from egad_workflow.job import run_job
from egad_workflow.shards import join


def run(tables: list[Path], by: list[str], joined: Path) -> None:
    """Combine the tables of all shards into one, sorted so that shards do not affect it."""
    phase(f"joining {len(tables)} tables")
    schema = parquet.schema_of(tables[0]).remove_metadata()
    parquet.write(join(tables, schema, by), schema, joined)


if __name__ == "__main__":
    run_job(run)
