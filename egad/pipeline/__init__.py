"""The pipeline: configuration, stages, commands, provenance and progress."""
