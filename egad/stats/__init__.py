"""Success rates with intervals, paired comparisons, ROC curves."""
