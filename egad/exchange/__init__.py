"""Objects, grasps and images in the formats of other programs: see `registry.py`."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
