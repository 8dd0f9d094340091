"""Grasp trials in simulation: the world, the gripper, the protocol of a trial."""
