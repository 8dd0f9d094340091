"""Provenance of files: recorded, printed as a tree, and verified."""
