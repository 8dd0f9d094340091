"""The evaluation set: selection, printability, plates, labels, datasheet, simulation bundle."""
