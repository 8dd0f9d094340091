"""Parallel-jaw grippers and their antipodal grasps: sampling, quality, collisions, labels."""
