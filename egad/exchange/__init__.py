"""Formats of other programs, in and out (`registry.py`), and datasets that anyone can host."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
