"""Evolution of objects: CPPN genomes, their voxels and meshes, and MAP-Elites."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
