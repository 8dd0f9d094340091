"""Grasp trials in simulation: the world, the gripper, and the protocol of a trial."""
