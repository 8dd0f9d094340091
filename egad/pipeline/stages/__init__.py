"""Stages: each reads and writes files, and calls the library in between."""
