"""Mesh files of other programs: one module a format, read by `read_mesh`."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
