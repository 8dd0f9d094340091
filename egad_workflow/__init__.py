"""Runs of the workflow: settings and their check, how a script runs, provenance, the display."""
