"""Pages about a run: the report and the training study."""
