"""Labelled grasps that were carried out, as the templates show them."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.evalset.selection import place
from egad.report.agreement_figure import agreement_chart
from egad.report.maps import data_uri
from egad.report.summary import outcome_counts
from egad.stats.rates import Rate, rate
from egad.stats.roc import Area, Bin, area, gain, reliability

QUALITIES = {"quality": "plain quality", "robust_quality": "robust quality", "held": "copies held"}
DRAWN = ("quality", "robust_quality")
NOT_DONE = ("collided", "failed", "crashed")


@dataclass(frozen=True)
class Agreement:
    """What came of labelled grasps.

    Attributes:
        rates: Successes of the grasps that could be carried out: in each row of the set, and then
            over all.
        outcomes: Grasps of the sample by outcome.
        labelled: Labelled grasps of the objects.
        free: Those of them that the hand can come to: what the sample was drawn from.
        objects: Objects with grasps that could be carried out.
        failing: Objects of which a grasp did not hold, in the same parts.
        areas: How well each quality tells of them, in the same parts.
        gain: What robust quality tells more than plain quality, over all.
        bins: Success by quality.
    """

    rates: list[Rate]
    outcomes: dict[str, int]
    labelled: int
    free: int
    objects: int
    failing: list[int]
    areas: dict[str, list[Area]]
    gain: Area
    bins: dict[str, list[Bin]]

    @property
    def svg(self) -> str:
        """The figure, as SVG text."""
        return agreement_chart(self.bins, {name: self.areas[name] for name in self.bins})

    @property
    def figure(self) -> str:
        """The same as an address."""
        return data_uri(self.svg.encode(), "image/svg+xml")


def agreement(table: pd.DataFrame, rows: int) -> Agreement:
    """Work out what there is to show.

    Grasps that the hand could not get to, because a convex part of the object sticks out or the
    simulation failed, tell nothing of the qualities and are left out of all rates.

    Args:
        table: Columns of `tables.evaluation.AGREEMENT`, at least one row.
        rows: Letters of the evaluation set.
    """
    done = table[~table["outcome"].isin(NOT_DONE)]
    row = np.array([place(label)[0] for label in done["label"]], dtype=np.int64)
    parts = [*(done[row == each] for each in range(rows)), done]
    objects = table.drop_duplicates("label")
    return Agreement(
        rates=[rate(each) for each in parts],
        outcomes=outcome_counts(table),
        labelled=int(objects["labelled"].sum()),
        free=int(objects["free"].sum()),
        objects=done["label"].nunique(),
        failing=[each.loc[~each["success"], "label"].nunique() for each in parts],
        areas={
            name: [area(*_told(each, key)) for each in parts] for key, name in QUALITIES.items()
        },
        gain=gain(done["robust_quality"].to_numpy(np.float64), *_told(done, "quality")),
        bins={QUALITIES[key]: reliability(done.assign(quality=done[key])) for key in DRAWN},
    )


def _told(
    done: pd.DataFrame, key: str
) -> tuple[NDArray[np.float64], NDArray[np.bool_], NDArray[np.str_]]:
    """A rating of grasps, whether they held, and of which object they are."""
    return (
        done[key].to_numpy(np.float64),
        done["success"].to_numpy(bool),
        done["label"].to_numpy(str),
    )
