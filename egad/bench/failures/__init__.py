"""Where a detector fails: objects that can be grasped, but that it does not grasp."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
