"""Grasp networks: datasets of rendered images, training and evaluation."""
