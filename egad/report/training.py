"""The chart of a training: losses and score."""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from egad.learning import best_epoch
from egad.report.colors import INK, LINES, SOFT
from egad.report.drawing import DASHED, new_figure, show_percent


def training_chart(history: pd.DataFrame) -> str:
    """Losses and the score on the validation set, over the images trained on.

    Args:
        history: Columns of `tables.training.HISTORY`, at least one row.

    Returns:
        SVG text. A line marks the epoch whose weights were kept.
    """
    images, kept = history["images"], best_epoch(history)["images"]
    dots: dict[str, Any] = {"marker": "o", "ms": 3}
    with new_figure(7.6, 3.0) as drawing:
        left, right = drawing.figure.subplots(1, 2)
        left.plot(images, history["loss"], color=LINES[0], label="training", **dots)
        left.plot(images, history["validation_loss"], color=LINES[1], label="validation", **dots)
        left.legend()
        right.plot(images, history["validation_score"], color=LINES[1], **dots)
        _label_axes(left, right, "loss")
        for axes in (left, right):
            axes.axvline(kept, color=SOFT, lw=0.8, ls=DASHED)
        right.annotate(
            "kept",
            (kept, 0.02),
            xytext=(-4, 0),
            textcoords="offset points",
            ha="right",
            color=INK,
            fontsize=8,
        )
    return drawing.svg


def _label_axes(left: Axes, right: Axes, loss: str) -> None:
    """Axes of losses, to the left, and of scores."""
    left.set(xlabel="images", ylabel=loss)
    right.set(xlabel="images", ylabel="correct grasps, validation", ylim=(0, 1.02))
    show_percent(right.yaxis)
    for axes in (left, right):
        axes.set_xlim(left=0)
        axes.grid(axis="y")
    left.set_ylim(bottom=0)
