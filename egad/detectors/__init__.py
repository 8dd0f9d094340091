"""Grasp detectors and what they see: their interface, those that egad ships, and your own."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
