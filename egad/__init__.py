"""Evolved objects for robot grasping: load, measure, scale, grasp, simulate and evolve them.

Everything that `__init__.pyi` lists is imported when it is first used, so `import egad` is quick.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
