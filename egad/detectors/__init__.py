"""Grasp detectors: what they get and return, those included, and your own."""
