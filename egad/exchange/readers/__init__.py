"""Formats of grasps that are read and not written, a module each: see `egad.exchange.registry`."""
