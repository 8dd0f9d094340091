"""Grasps: antipodal and suction, their sampling, quality, labels and collisions of the hand."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
