"""Formats of rendered images: one module per format."""
