"""Formats of rendered images: one module a format."""
