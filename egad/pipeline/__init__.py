"""The pipeline: configuration, stages, exports, commands, provenance and progress."""
