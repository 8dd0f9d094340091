"""The section Labels and simulation: how well labelled qualities predict simulated success."""

import string
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.bench.stats import Area, Bin, Rate, area, engine_names, gain, rate, reliability
from egad.evalset import cell_of_label, in_grid
from egad.report.colors import LINES, SOFT
from egad.report.drawing import DASHED, new_figure, show_percent
from egad.report.page import svg_uri
from egad.report.trial_charts import draw_rates, outcome_counts

QUALITIES = {
    "quality": "nominal quality",
    "robust_quality": "robust quality",
    "robust_success_rate": "robust success rate",
}
CHARTED = ("quality", "robust_quality")
NOT_TRIED = ("collided", "failed", "crashed")


@dataclass(frozen=True)
class LabelledSuccess:
    """Labelled grasps and their success in simulation."""

    engine: str
    # success of the grasps that could be carried out: in each row of the evaluation set, if
    # it is a grid, and then over all
    rates: list[Rate]
    outcomes: dict[str, int]
    labelled: int  # labelled grasps of the objects
    free: int  # labelled grasps without collision, from which the sample was drawn
    objects: int  # objects with grasps that could be carried out
    failing: list[int]  # objects with a failed grasp: in each row, and then over all
    areas: dict[str, list[Area]]  # ROC area of each quality: in each row, and then over all
    gain: Area  # ROC area of robust quality minus that of nominal quality, over all
    bins: dict[str, list[Bin]]

    @property
    def svg(self) -> str:
        """The figure, as SVG text."""
        return agreement_chart(self.bins, {name: self.areas[name] for name in self.bins})

    @property
    def figure(self) -> str:
        """The figure as an address."""
        return svg_uri(self.svg)


def agreement(table: pd.DataFrame, rows: int) -> LabelledSuccess:
    """What the section shows of `AGREEMENT`; grasps that the hand could not reach do not count."""
    tried = table[~table["outcome"].isin(NOT_TRIED)]
    groups = [tried]
    if in_grid(set(table["label"])):
        row = np.array([cell_of_label(label)[0] for label in tried["label"]], dtype=np.int64)
        groups = [*(tried[row == each] for each in range(rows)), tried]
    objects = table.drop_duplicates("label")
    return LabelledSuccess(
        engine=engine_names(table),
        rates=[rate(each) for each in groups],
        outcomes=outcome_counts(table),
        labelled=int(objects["n_labelled"].sum()),
        free=int(objects["n_collision_free"].sum()),
        objects=tried["label"].nunique(),
        failing=[each.loc[~each["success"], "label"].nunique() for each in groups],
        areas={
            name: [area(*_ratings(each, key)) for each in groups] for key, name in QUALITIES.items()
        },
        gain=gain(tried["robust_quality"].to_numpy(np.float64), *_ratings(tried, "quality")),
        bins={QUALITIES[key]: reliability(tried.assign(quality=tried[key])) for key in CHARTED},
    )


def _ratings(
    grasps: pd.DataFrame, key: str
) -> tuple[NDArray[np.float64], NDArray[np.bool_], NDArray[np.str_]]:
    """A rating of grasps, whether they succeeded, and the objects that they belong to."""
    return (
        grasps[key].to_numpy(np.float64),
        grasps["success"].to_numpy(bool),
        grasps["label"].to_numpy(str),
    )


def agreement_chart(bins: Mapping[str, Sequence[Bin]], areas: Mapping[str, Sequence[Area]]) -> str:
    """SVG of success over the rank by quality, and of ROC areas by row of the set and over all."""
    with new_figure(8.6, 3.2) as drawing:
        left, right = drawing.figure.subplots(1, 2, width_ratios=[1, 1.25])
        for number, (name, each) in enumerate(bins.items()):
            if each:
                rates = [one.rate for one in each]
                draw_rates(left, _ranks(rates), rates, LINES[number], name)
        left.set(xlim=(0, 1), xlabel="grasps by quality, worst to best", ylabel="success rate")
        for axis in (left.xaxis, left.yaxis):
            show_percent(axis)
        left.grid(axis="y")
        for number, row in enumerate(areas.values()):
            offset = 0.24 * (number - (len(areas) - 1) / 2)
            for place, one in enumerate(row):
                right.plot(place + offset, one.value, "o", color=LINES[number], ms=5)
                right.vlines(place + offset, *one.interval, color=LINES[number], lw=1)
        right.axhline(0.5, color=SOFT, lw=0.8, ls=DASHED)
        count = max(map(len, areas.values()))
        right.set_xticks(range(count), [*string.ascii_uppercase[: count - 1], "all"])
        right.tick_params(axis="x", length=0)
        right.set(ylim=(0, 1.02), xlabel="row, easy to hard", ylabel="area under the ROC curve")
        right.grid(axis="y")
        drawing.figure.legend(
            *left.get_legend_handles_labels(), loc="outside upper center", ncols=3
        )
    return drawing.svg


def _ranks(rates: Sequence[Rate]) -> list[float]:
    """Middle rank of the attempts of each rate, from 0 to 1."""
    counts = np.array([rate.attempts for rate in rates])
    ranks: list[float] = ((np.cumsum(counts) - counts / 2) / counts.sum()).tolist()
    return ranks
