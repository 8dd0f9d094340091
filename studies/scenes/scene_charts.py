"""The chart of the study of scenes: what networks clear over their number of training scenes."""

from collections.abc import Mapping

import pandas as pd

from egad.report.colors import SOFT, line_color
from egad.report.drawing import new_figure, show_percent


def learning_chart(rounds: pd.DataFrame, scenes: Mapping[str, int], family: str) -> str:
    """The share that networks clear over the number of their training scenes, a panel per test.

    Args:
        rounds: Of one condition: `test`, `detector`, `name` of its set, `cleared` and `there`.
        scenes: Training scenes of each set.
        family: The set whose smaller versions, `FAMILY-...`, are joined with it by a line.

    Returns:
        SVG text: dots are networks, lines go through means, and dashed lines are detectors that
        belong to no set.
    """
    tests = list(rounds["test"].unique())
    with new_figure(1.2 + 2.9 * len(tests), 3.3) as drawing:
        panels = drawing.figure.subplots(1, len(tests), squeeze=False, sharey=True)[0]
        for axes, test in zip(panels, tests, strict=True):
            shares = cleared_by(rounds[rounds["test"] == test])
            shares["scenes"] = shares["name"].map(scenes)
            trained = shares.dropna(subset="scenes")
            line = trained["name"].where(~trained["name"].str.startswith(f"{family}-"), family)
            for number, (name, some) in enumerate(trained.groupby(line, sort=False)):
                color = line_color(number)
                axes.plot(some["scenes"], some["share"], "o", mfc="none", color=color)
                mean = some.groupby("scenes")["share"].mean()
                axes.plot(mean.index, mean, ".-", color=color, label=name)
            for style, (_, row) in zip(
                ("--", ":", "-."), shares[shares["scenes"].isna()].iterrows(), strict=False
            ):
                axes.axhline(row["share"], color=SOFT, linestyle=style, label=row["name"])
            axes.set_title(test, size=10, loc="left")
            axes.set(xscale="log", xlabel="training scenes")
            axes.set_xticks(sorted(set(scenes.values())), sorted(set(scenes.values())))
            axes.minorticks_off()
            axes.grid(axis="y")
        panels[0].set_ylabel("objects cleared")
        show_percent(panels[0].yaxis)
        panels[-1].legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    return drawing.svg


def cleared_by(rounds: pd.DataFrame) -> pd.DataFrame:
    """The share that each detector clears: `name`, `detector`, `share`."""
    sums = rounds.groupby(["name", "detector"], sort=False)[["cleared", "there"]].sum()
    return (sums["cleared"] / sums["there"]).rename("share").reset_index()
