"""Grasp trials in simulation: the world, the gripper, and the protocol of a trial."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
