"""Tables for people: Parquet or CSV, as the file name says."""

from pathlib import Path

import pandas as pd
import pyarrow as pa

from egad._util.files import atomic_output
from egad.tables import parquet


def write_frame(frame: pd.DataFrame, schema: pa.Schema, path: Path) -> None:
    """Write the columns of a schema as Parquet, or as CSV where lists are joined by spaces."""
    whole = frame.reindex(columns=schema.names)
    if path.suffix.lower() == ".parquet":
        parquet.write(whole, schema, path)
        return
    for field in schema:
        if pa.types.is_list(field.type):
            lists = [each if isinstance(each, list) else [] for each in whole[field.name]]
            whole[field.name] = [" ".join(map(str, each)) for each in lists]
        elif pa.types.is_integer(field.type):
            whole[field.name] = whole[field.name].astype("Int64")
    with atomic_output(path) as temporary:
        whole.to_csv(temporary, index=False)


def write_matrix(matrix: pd.DataFrame, path: Path) -> None:
    """Write a matrix whose index and columns are names; the names are its first column."""
    named = matrix.rename_axis("name").reset_index()
    with atomic_output(path) as temporary:
        if path.suffix.lower() == ".parquet":
            named.to_parquet(temporary, index=False)
        else:
            named.to_csv(temporary, index=False)
