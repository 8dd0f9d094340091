"""The schema of every table (columns, units and meanings), and how tables are read and written."""
