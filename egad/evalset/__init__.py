"""The evaluation set: chosen, and made ready for printers."""
