"""Simulated grasping trials."""
