"""Antipodal grasps of a parallel-jaw gripper, and how good they are."""
