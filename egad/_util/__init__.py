"""Helpers that all packages share: files, worker processes, progress, compiled code, limits."""
