"""Charts of trained networks: loss and score while they train, and their success in trials."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from numpy.typing import NDArray

from egad.report.colors import INK, LINES, SOFT, line_color
from egad.report.drawing import new_figure, show_percent
from egad.stats import Mean, TestAttempts

STYLES = ("-", "--", ":", "-.")


def training_chart(history: pd.DataFrame) -> str:
    """Losses and the score on the validation set, over the images trained on.

    Args:
        history: Columns of `tables.training.HISTORY`, at least one row.

    Returns:
        SVG text.
    """
    images = history["images"]
    dots: dict[str, Any] = {"marker": "o", "ms": 3}
    with new_figure(7.6, 3.0) as drawing:
        left, right = drawing.figure.subplots(1, 2)
        left.plot(images, history["loss"], color=LINES[0], label="training", **dots)
        left.plot(images, history["validation_loss"], color=LINES[1], label="validation", **dots)
        left.legend()
        right.plot(images, history["validation_score"], color=LINES[1], **dots)
        _label_axes(left, right, "loss")
    return drawing.svg


def openings_chart(openings: NDArray[np.float64], most: float) -> str:
    """How far the hand opens for the grasps in a set of images.

    Args:
        openings: Metres, (n,).
        most: Opening of the gripper, metres.

    Returns:
        SVG text.
    """
    with new_figure(5.0, 2.4) as drawing:
        axes = drawing.figure.subplots()
        bins = np.linspace(0, 1000 * most, 17)
        # At the full opening, some are a rounding error wider.
        values = np.minimum(1000 * openings, bins[-1])
        shares = np.full(len(values), 1 / max(len(values), 1))
        axes.hist(values, bins.tolist(), weights=shares, color=LINES[0], edgecolor="white", lw=0.5)
        axes.set(xlabel="opening of good grasps, mm", ylabel="of the grasps")
        show_percent(axes.yaxis)
    return drawing.svg


def training_curves(
    histories: Mapping[str, Sequence[pd.DataFrame]], colors: Mapping[str, str]
) -> str:
    """Validation loss and score of all networks, over the images trained on.

    Args:
        histories: Columns of `tables.training.HISTORY` of each network, by training set.
        colors: From `set_colors`.

    Returns:
        SVG text: a color a set, a line style a network.
    """
    with new_figure(8.6, 3.2) as drawing:
        left, right = drawing.figure.subplots(1, 2)
        for name, each in histories.items():
            for number, history in enumerate(each):
                images = history["images"]
                line: dict[str, Any] = {"ls": STYLES[number % len(STYLES)], "color": colors[name]}
                label = name if number == 0 else None
                left.plot(images, history["validation_loss"], label=label, **line)
                right.plot(images, history["validation_score"], **line)
        _label_axes(left, right, "validation loss")
        drawing.figure.legend(loc="outside upper center", ncols=6, fontsize=9)
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


def set_colors(names: Sequence[str]) -> dict[str, str]:
    """The color of each training set, the same in all charts."""
    return {name: line_color(number) for number, name in enumerate(names)}


def success_chart(tests: Mapping[str, TestAttempts]) -> str:
    """Success of each training set, a panel a test.

    Args:
        tests: What was tried, by test.

    Returns:
        SVG text: a filled dot is the rate over all networks of a set, with its interval of 95 %;
        hollow dots are single networks; other detectors are grey.
    """
    rows = max(len(tried.sets) + len(tried.references) for tried in tests.values())
    with new_figure(1.2 + 3.7 * len(tests), 0.9 + 0.34 * rows) as drawing:
        panels = drawing.figure.subplots(1, len(tests), squeeze=False)[0]
        for axes, (test, tried) in zip(panels, tests.items(), strict=True):
            _draw_success(axes, tried)
            names = [*tried.sets, *tried.references]
            axes.set_yticks(range(len(names)), names)
            axes.set(xlim=(0, 1), ylim=(len(names) - 0.5, -0.5), title=test, xlabel="success rate")
            show_percent(axes.xaxis)
            axes.tick_params(axis="y", length=0)
            axes.grid(axis="x")
    return drawing.svg


def _draw_success(axes: Axes, tried: TestAttempts) -> None:
    """A row for each set, and then for each other detector."""
    colors = set_colors(list(tried.sets))
    for row, (name, found) in enumerate(tried.sets.items()):
        _draw_rate(axes, row, found.pooled, colors[name])
        each = [one.value for one in found.each.values()]
        axes.plot(each, [row + 0.22] * len(each), "o", ms=4, color=INK, mfc="none", mew=0.8)
    for row, mean in enumerate(tried.references.values(), len(tried.sets)):
        _draw_rate(axes, row, mean, SOFT)


def _draw_rate(axes: Axes, row: int, mean: Mean, color: str) -> None:
    axes.hlines(row, *mean.interval, color=color, lw=1.6)
    axes.plot([mean.value], [row], "o", ms=6, color=color)


def score_chart(
    points: Mapping[str, Sequence[tuple[float, float]]], colors: Mapping[str, str]
) -> str:
    """Success in trials against the score on images of held-out objects, one dot per network.

    Args:
        points: Score and success of each network, by training set.
        colors: From `set_colors`.

    Returns:
        SVG text.
    """
    with new_figure(4.6, 3.4) as drawing:
        axes = drawing.figure.add_subplot()
        for name, each in points.items():
            axes.plot(*zip(*each, strict=True), "o", ms=6, color=colors[name], label=name)
        axes.set(xlim=(0, 1), ylim=(0, 1), xlabel="correct grasps, test images of its own set")
        axes.set_ylabel("success in trials")
        for axis in (axes.xaxis, axes.yaxis):
            show_percent(axis)
        axes.grid()
        drawing.figure.legend(loc="outside right upper", fontsize=9)
    return drawing.svg
