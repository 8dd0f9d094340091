"""The chart of a training run: losses and score."""

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.report.colors import LINES
from egad.report.drawing import new_figure, show_percent


def training_chart(history: pd.DataFrame) -> str:
    """SVG of losses and validation score over images, from `tables.training.HISTORY`."""
    return _chart(history, "images", "validation_score", "correct grasps, validation")


def scene_training_chart(history: pd.DataFrame) -> str:
    """SVG of losses and validation precision over scenes, from `tables.training.SCENE_HISTORY`."""
    name = "validation_average_precision"
    return _chart(history, "scenes", name, "average precision, validation")


def _chart(history: pd.DataFrame, unit: str, score: str, title: str) -> str:
    examples = history[unit]
    dots: dict[str, Any] = {"marker": "o", "ms": 3}
    with new_figure(7.6, 3.0) as drawing:
        left, right = drawing.figure.subplots(1, 2)
        left.plot(examples, history["loss"], color=LINES[0], label="training", **dots)
        left.plot(examples, history["validation_loss"], color=LINES[1], label="validation", **dots)
        left.legend()
        right.plot(examples, history[score], color=LINES[1], **dots)
        left.set(xlabel=unit, ylabel="loss")
        right.set(xlabel=unit, ylabel=title, ylim=(0, 1.02))
        show_percent(right.yaxis)
        for axes in (left, right):
            axes.set_xlim(left=0)
            axes.grid(axis="y")
        left.set_ylim(bottom=0)
    return drawing.svg


def openings_chart(openings: NDArray[np.float64], most: float) -> str:
    """SVG of how far the hand opens (m, (n,), up to `most`) for the grasps in a set of images."""
    with new_figure(5.0, 2.4) as drawing:
        axes = drawing.figure.subplots()
        bins = np.linspace(0, 1000 * most, 17)
        # Some fully open grasps are wider by a rounding error.
        values = np.minimum(1000 * openings, bins[-1])
        shares = np.full(len(values), 1 / max(len(values), 1))
        axes.hist(values, bins.tolist(), weights=shares, color=LINES[0], edgecolor="white", lw=0.5)
        axes.set(xlabel="opening of good grasps, mm", ylabel="of the grasps")
        show_percent(axes.yaxis)
    return drawing.svg
