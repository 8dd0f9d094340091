"""A fixed assignment of objects to shards, independent of the other objects."""

import hashlib
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa

from egad.errors import UserError
from egad.tables import parquet


def shard_of(object_id: str, shards: int) -> int:
    """The shard that an object belongs to, by a hash of its id."""
    digest = hashlib.sha256(object_id.encode()).digest()
    return int.from_bytes(digest[:8], "little") % shards


def in_shard(object_id: str, shard: int, shards: int) -> bool:
    """Whether an object belongs to a shard."""
    return shard_of(object_id, shards) == shard


def by_shard(object_ids: Iterable[str], shards: int) -> list[list[str]]:
    """The objects of each shard, in their order."""
    found: list[list[str]] = [[] for _ in range(shards)]
    for object_id in object_ids:
        found[shard_of(object_id, shards)].append(object_id)
    return found


def rows_in_shard(frame: pd.DataFrame, shard: int, shards: int) -> pd.DataFrame:
    """The rows of the objects of a shard."""
    chosen = [in_shard(object_id, shard, shards) for object_id in frame["id"]]
    return frame.loc[np.array(chosen, dtype=bool)]


def join(parts: list[Path], schema: pa.Schema, order: list[str]) -> pd.DataFrame:
    """The rows of all shards as one table, sorted to be independent of the number of shards."""
    frames = [parquet.read(part, schema) for part in parts]
    filled = [frame for frame in frames if len(frame)]
    if not filled:
        return parquet.empty(schema)
    return pd.concat(filled).sort_values(order, ignore_index=True)


def remove_leftovers(folder: Path, names: Sequence[str], shards: int) -> None:
    """Remove the shards of an earlier, larger set.

    Args:
        folder: Of the set.
        names: What the names of its files begin with: `NAME-0.parquet`, ...
        shards: Number of its shards.

    Raises:
        UserError: The set that is there has another number of shards.
    """
    if parquet.notes(folder / f"{names[0]}-0.parquet").get("shards") != shards:
        raise UserError(f"{folder}: expected {names[0]} in {shards} shards; make them again")
    wanted = {f"{name}-{number}.parquet" for name in names for number in range(shards)}
    for path in [path for name in names for path in folder.glob(f"{name}-*.parquet")]:
        if path.name not in wanted:
            path.unlink()


def rejection(object_id: str, stage: str, reason: object) -> dict[str, str]:
    """A row of `tables.objects.REJECTED`."""
    return {"id": object_id, "stage": stage, "reason": str(reason)}
