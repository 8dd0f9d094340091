"""A dataset that anyone can host: its tables, card, licence and citation."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
