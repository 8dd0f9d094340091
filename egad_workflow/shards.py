"""A fixed assignment of objects to shards, independent of the other objects."""

import hashlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa

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
