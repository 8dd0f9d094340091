"""Sets of rows in several files: NAME-0.parquet, NAME-1.parquet and so on, which belong together.

Each file notes its number, `shard`, and how many there are, `shards`.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

import pandas as pd
import pyarrow as pa

from egad.errors import UserError
from egad.tables import parquet


def shard_files(folder: Path, names: Sequence[str], target: str) -> list[tuple[Path, ...]]:
    """The files of each shard of a folder, by number; `UserError` with the target if incomplete."""
    found = {path.name: path for name in names for path in sorted(folder.glob(f"{name}-*.parquet"))}
    if not found:
        raise UserError(f"{folder}: no {names[0]} found; make them with {target}")
    notes = {name: parquet.notes(path) for name, path in found.items()}
    sets = [{**each, "shard": None} for each in notes.values()]
    origins = [parquet.origin_of(path) for path in found.values()]
    made = [{key: each.get(key) for key in ("settings", "inputs")} for each in origins]
    total = sets[0].get("shards")
    if not isinstance(total, int) or any(
        each != all_of[0] for all_of in (sets, made) for each in all_of
    ):
        raise UserError(f"{folder}: its shards are of several sets; make them again")
    whole = [[f"{name}-{number}.parquet" for name in names] for number in range(total)]
    if missing := [name for shard in whole for name in shard if name not in notes]:
        few = ", ".join(missing[:3]) + (f" and {len(missing) - 3} more" if missing[3:] else "")
        raise UserError(f"{folder}: incomplete, {few} of {total} shards missing")
    return [tuple(found[name] for name in shard) for shard in whole]


def rows_of(paths: Iterable[Path], schema: pa.Schema, names: list[str]) -> pd.DataFrame:
    """Some columns of tables of the same schema, one after the other; or `TableError`."""
    parts = [rows for path in paths for rows in parquet.batches(path, names)]
    return pd.concat(parts, ignore_index=True) if parts else parquet.empty(schema)[names]


def remove_leftovers(folder: Path, names: Sequence[str], shards: int) -> None:
    """Remove files of an earlier, larger set; `UserError` if the set has not `shards` shards."""
    if parquet.notes(folder / f"{names[0]}-0.parquet").get("shards") != shards:
        raise UserError(f"{folder}: expected {names[0]} in {shards} shards; make them again")
    for name in names:
        wanted = {f"{name}-{number}.parquet" for number in range(shards)}
        for path in list(folder.glob(f"{name}-*.parquet")):
            if path.name not in wanted:
                path.unlink()
