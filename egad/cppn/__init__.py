"""CPPN genomes, the voxels and meshes that they describe, and constraints on their shapes."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
