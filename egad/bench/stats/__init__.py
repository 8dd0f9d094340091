"""Success rates with confidence intervals, paired comparisons, and ROC curves."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
