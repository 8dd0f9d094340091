"""CPPN genomes, and the voxels and meshes that they describe."""
