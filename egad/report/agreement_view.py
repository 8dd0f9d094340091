"""Labelled grasps that were carried out, as the templates show them."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from egad.evalset.labels import place
from egad.report.agreement_figure import agreement_chart
from egad.report.maps import data_uri
from egad.report.summary import outcome_counts
from egad.trials.ranking import Area, area
from egad.trials.reliability import reliability
from egad.trials.statistics import Rate, rate

QUALITIES = {"quality": "plain quality", "robust_quality": "robust quality", "held": "held"}
DRAWN = ("quality", "robust_quality")
NOT_DONE = ("collided", "failed", "crashed")


@dataclass(frozen=True)
class Agreement:
    """What came of labelled grasps.

    Attributes:
        rate: Successes of the grasps that could be carried out.
        outcomes: Grasps of the sample by outcome.
        labelled: Labelled grasps of the objects.
        free: Those of them that the hand can come to: what the sample was drawn from.
        objects: Objects with grasps that could be carried out.
        areas: How well each quality tells: over all, and then in each row of the set.
        figure: The same drawn, as an address.
    """

    rate: Rate
    outcomes: dict[str, int]
    labelled: int
    free: int
    objects: int
    areas: dict[str, list[Area]]
    figure: str


def agreement(table: pd.DataFrame, rows: int) -> Agreement:
    """Work out what there is to show.

    Grasps that the hand could not get to, because a convex part of the object sticks out or the
    simulation failed, tell nothing of the qualities and are left out of all rates.

    Args:
        table: Columns of `tables.evaluation.AGREEMENT`, at least one row.
        rows: Letters of the evaluation set.
    """
    done = table[~table["outcome"].isin(NOT_DONE)]
    objects = table.drop_duplicates("label")
    areas = {key: _areas(done, key, rows) for key in QUALITIES}
    bins = {
        QUALITIES[key]: reliability(done.assign(quality=done[key])) for key in DRAWN if len(done)
    }
    shown = {QUALITIES[key]: [*areas[key][1:], areas[key][0]] for key in DRAWN}
    figure = agreement_chart(bins, shown)
    return Agreement(
        rate=rate(done),
        outcomes=outcome_counts(table),
        labelled=int(objects["labelled"].sum()),
        free=int(objects["free"].sum()),
        objects=done["label"].nunique(),
        areas={QUALITIES[key]: found for key, found in areas.items()},
        figure=data_uri(figure.encode(), "image/svg+xml"),
    )


def _areas(done: pd.DataFrame, key: str, rows: int) -> list[Area]:
    row = np.array([place(label)[0] for label in done["label"]], dtype=np.int64)
    return [_area(done, key), *(_area(done[row == each], key) for each in range(rows))]


def _area(done: pd.DataFrame, key: str) -> Area:
    return area(
        done[key].to_numpy(np.float64),
        done["success"].to_numpy(bool),
        done["label"].to_numpy(str),
    )
