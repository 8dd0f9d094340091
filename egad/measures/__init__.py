"""Mesh -> its coordinates in the space: complexity, difficulty, similarity to others."""
