"""Genome -> voxels -> watertight mesh."""
