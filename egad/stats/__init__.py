"""Success rates with confidence intervals, paired comparisons, and ROC curves."""
