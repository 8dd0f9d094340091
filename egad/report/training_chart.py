"""The chart of a training, as SVG text."""

import pandas as pd

from egad.learning.model_card import taken
from egad.report.style import INK, LINES, SOFT, drawn


def training_chart(history: pd.DataFrame) -> str:
    """Losses and the score on the validation set, over the images learnt from.

    Args:
        history: Columns of `tables.training.HISTORY`, at least one row.

    Returns:
        SVG text. A line marks the epoch whose weights were taken.
    """
    images = history["images"].to_numpy()
    chosen = taken(history)["images"]
    with drawn(7.6, 3.0) as drawing:
        left, right = drawing.figure.subplots(1, 2)
        left.plot(images, history["loss"], "o-", ms=3, color=LINES[0], label="training")
        left.plot(
            images, history["validation_loss"], "o-", ms=3, color=LINES[1], label="validation"
        )
        left.set(xlabel="images", ylabel="loss")
        left.set_ylim(bottom=0)
        left.legend()
        right.plot(images, history["validation_score"], "o-", ms=3, color=LINES[1])
        right.set(xlabel="images", ylabel="right grasps, validation", ylim=(0, 1.02))
        right.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
        for axes in (left, right):
            axes.set_xlim(left=0)
            axes.grid(axis="y")
            axes.axvline(chosen, color=SOFT, lw=0.8, ls=(0, (4, 4)))
        right.annotate(
            "taken",
            (chosen, 0.02),
            xytext=(-4, 0),
            textcoords="offset points",
            ha="right",
            color=INK,
            fontsize=8,
        )
    return drawing.svg
