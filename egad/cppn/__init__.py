"""CPPN genomes, the voxels and meshes that they describe, and constraints on their shapes."""
