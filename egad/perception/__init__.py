"""Depth cameras, sensor noise, and rendered images of objects with their grasps."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
