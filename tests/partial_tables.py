"""Tables of which only some columns matter to a test."""

import pandas as pd
import pyarrow as pa

from egad.tables import parquet

EMPTY = {pa.string(): "", pa.binary(): b"", pa.large_binary(): b"", pa.bool_(): False}


def fill_columns(schema, rows):
    """These rows, as a table or as dictionaries; what they lack is zero, no or empty."""
    blank = {
        field.name: [] if pa.types.is_list(field.type) else EMPTY.get(field.type, 0)
        for field in schema
    }
    given = rows.to_dict("records") if isinstance(rows, pd.DataFrame) else rows
    unknown = {name for row in given for name in row} - set(blank)
    assert not unknown, f"no columns of the schema: {unknown}"
    return pd.DataFrame([blank | row for row in given])


def write_rows(schema, rows, path, notes=None):
    """Write these rows, filled, to a Parquet file."""
    parquet.write(fill_columns(schema, rows), schema, path, notes)
