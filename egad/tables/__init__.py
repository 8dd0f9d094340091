"""The Arrow schema of every Parquet artefact: columns, units and meanings."""
