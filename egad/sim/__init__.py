"""The simulated world: physics engines, hands and arms, and the execution of a grasp."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
