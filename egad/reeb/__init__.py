"""Multiresolution Reeb graphs of shapes, their matching, and exact nearest neighbors."""
