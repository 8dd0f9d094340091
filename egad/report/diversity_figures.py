"""Charts of networks that learnt from different objects, as SVG text."""

from collections.abc import Mapping, Sequence

import pandas as pd
from matplotlib.axes import Axes

from egad.report.style import INK, LINES, SOFT, drawn
from egad.stats.rates import Mean
from egad.stats.training_study import Tried

PERCENT = "{:.0%}".format
STYLES = ("-", "--", ":", "-.")


def colours(names: Sequence[str]) -> dict[str, str]:
    """The colour of each training set, the same in all charts."""
    return {name: LINES[number % len(LINES)] for number, name in enumerate(names)}


def success_chart(tests: Mapping[str, Tried]) -> str:
    """Success of each training set, a panel a test.

    Args:
        tests: What was tried, by test.

    Returns:
        SVG text: a filled dot is the rate over all networks of a set, with its interval of 95 %;
        hollow dots are single networks; other detectors are grey.
    """
    rows = max(len(tried.sets) + len(tried.references) for tried in tests.values())
    with drawn(1.2 + 3.7 * len(tests), 0.9 + 0.34 * rows) as drawing:
        panels = drawing.figure.subplots(1, len(tests), squeeze=False)[0]
        for axes, (test, tried) in zip(panels, tests.items(), strict=True):
            rates, others = tried.sets, tried.references
            for place, (name, found) in enumerate(rates.items()):
                _row(axes, place, found.pooled, colours(list(rates))[name])
                each = [one.value for one in found.each.values()]
                axes.plot(
                    *(each, [place + 0.22] * len(each)), "o", ms=4, color=INK, mfc="none", mew=0.8
                )
            for place, mean in enumerate(others.values(), len(rates)):
                _row(axes, place, mean, SOFT)
            names = [*rates, *others]
            axes.set_yticks(range(len(names)), names)
            axes.set(xlim=(0, 1), ylim=(len(names) - 0.5, -0.5), title=test, xlabel="success rate")
            axes.xaxis.set_major_formatter(lambda value, _: PERCENT(value))
            axes.tick_params(axis="y", length=0)
            axes.grid(axis="x")
    return drawing.svg


def _row(axes: Axes, place: int, mean: Mean, colour: str) -> None:
    axes.hlines(place, *mean.interval, color=colour, lw=1.6)
    axes.plot([mean.value], [place], "o", ms=6, color=colour)


def score_chart(
    points: Mapping[str, Sequence[tuple[float, float]]], inks: Mapping[str, str]
) -> str:
    """Success in trials against the score on images of held-out objects, a dot a network.

    Args:
        points: Score and success of each network, by training set.
        inks: From `colours`.

    Returns:
        SVG text.
    """
    with drawn(4.6, 3.4) as drawing:
        axes = drawing.figure.add_subplot()
        for name, each in points.items():
            axes.plot(*zip(*each, strict=True), "o", ms=6, color=inks[name], label=name)
        axes.set(xlim=(0, 1), ylim=(0, 1), xlabel="right grasps, test images of its own set")
        axes.set_ylabel("success in trials")
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(lambda value, _: PERCENT(value))
        axes.grid()
        drawing.figure.legend(loc="outside right upper", fontsize=9)
    return drawing.svg


def training_curves(
    histories: Mapping[str, Sequence[pd.DataFrame]], inks: Mapping[str, str]
) -> str:
    """How all networks learnt.

    Args:
        histories: Columns of `tables.training.HISTORY` of each network, by training set.
        inks: From `colours`.

    Returns:
        SVG text: a colour a set, a kind of line a network.
    """
    with drawn(8.6, 3.2) as drawing:
        left, right = drawing.figure.subplots(1, 2)
        for name, each in histories.items():
            for number, history in enumerate(each):
                images, line = history["images"], STYLES[number % len(STYLES)]
                label = name if number == 0 else None
                left.plot(images, history["validation_loss"], line, color=inks[name], label=label)
                right.plot(images, history["validation_score"], line, color=inks[name])
        left.set(xlabel="images", ylabel="validation loss")
        right.set(xlabel="images", ylabel="right grasps, validation", ylim=(0, 1.02))
        right.yaxis.set_major_formatter(lambda value, _: PERCENT(value))
        for axes in (left, right):
            axes.set_xlim(left=0)
            axes.grid(axis="y")
        left.set_ylim(bottom=0)
        drawing.figure.legend(loc="outside upper center", ncols=6, fontsize=9)
    return drawing.svg
