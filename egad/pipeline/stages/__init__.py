"""Stages, one module each: they read and write files and call the library in between."""
