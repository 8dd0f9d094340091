"""Measures of an object: complexity, grasp difficulty, similarity; the grid they span."""
