"""A page that explains the failures of a detector: where, why, at which shapes, and films."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import pandas as pd

from egad._util.arrays import Floats
from egad.bench.failures import ObjectVerdict
from egad.bench.failures.features import ExplainedShare, ShapeFeature
from egad.bench.stats import Rate
from egad.measures import MeasureSpace, cell_name, labels
from egad.report.axes import AxisPair
from egad.report.colors import FAINT, LINES, SOFT
from egad.report.drawing import new_figure
from egad.report.failure_map import dataset_map, failure_map, lowest_difference
from egad.report.page import data_uri, render_template, svg_uri
from egad.report.trial_charts import outcome_chart, outcome_counts

MAX_OF_CELL = 2  # failures per cell among the worst
BEYOND = 0.6  # of the range of solved objects; charts of features extend this far on either side
REASONS = {
    "n_nothing": ("nothing was proposed", LINES[3]),
    "n_not_chosen": ("another of its first ten proposals holds", LINES[5]),
    "n_none_good": ("none of its first ten proposals holds", LINES[1]),
}
WHO = ("detector", "reference")


class FeatureShare(NamedTuple):
    """A shape feature, and how it distinguishes failures from objects that the detector solves."""

    feature: ShapeFeature
    share: ExplainedShare  # of the failures; its range is in the unit of the page, as are the next
    solved: Floats  # its value for each solved object
    failures: Floats  # its value for each failure

    @property
    def medians(self) -> tuple[float, float]:
        """Medians of the solved objects and of the failures."""
        return float(np.median(self.solved)), float(np.median(self.failures))


@dataclass(frozen=True)
class AttemptFilm:
    """A film of an attempt."""

    outcome: str
    content: bytes = b""  # an animated WebP file; empty if there is none


@dataclass(frozen=True)
class Example:
    """What is shown of one of the worst failures besides its numbers."""

    picture: bytes
    # films of the same drop, by `detector` and `reference`
    films: Mapping[str, AttemptFilm] = field(default_factory=dict)
    note: str = ""  # why an expected film is missing


@dataclass(frozen=True)
class SearchText:
    """What a page says about the search."""

    detector: str  # its name; empty if unknown
    hand: str  # the hand, in words
    approach: str  # above or any
    contact: str  # what a contact on the way down means, in words
    engines: Sequence[str]
    reference: float  # minimum success rate of the reference at a failure
    difference: float  # minimum difference from the success rate of the detector
    confidence: float  # confidence of both


class EngineRates(NamedTuple):
    """Results of the fresh drops of a failure in an engine."""

    engine: str
    reference: Rate
    detector: Rate
    difference: float


class Reason(NamedTuple):
    """A reason why a detector fails, how often it occurs, and its color."""

    text: str
    color: str
    drops: int
    share: float


def page(
    table: pd.DataFrame,
    examined: pd.DataFrame,
    attempts: pd.DataFrame,
    *,
    search: SearchText,
    dataset: pd.DataFrame,
    features: Sequence[FeatureShare],
    examples: Mapping[str, Example],
    space: MeasureSpace,
    axes: AxisPair,
) -> str:
    """An HTML page that needs no other file, from the three tables of `tables.failures`."""
    fresh = attempts[(attempts["purpose"] == "confirm") & attempts["id"].isin(set(table["id"]))]
    labelled = table.assign(label=failure_labels(table))
    rows = {str(row["id"]): row for _, row in labelled.iterrows()}
    return render_template(
        "failures_page.html.j2",
        search=search,
        count=len(table),
        cells=len(table[["complexity_cell", "difficulty_cell"]].drop_duplicates()),
        attempts=int(examined["attempts"].sum()),
        tried=int((examined["attempts"] > 0).sum()),
        verdicts=_verdicts(examined),
        examined=len(examined),
        sources=_sources(examined),
        difference_map=svg_uri(failure_map(table, examined, space, axes)),
        dataset_map=svg_uri(dataset_map(dataset, space, axes)),
        reasons=reasons_of(table),
        outcome_figure=svg_uri(outcome_chart(_by_who(fresh))) if len(fresh) else "",
        outcomes=lost_outcomes(fresh),
        features=features,
        feature_figure=svg_uri(feature_chart(features)) if features else "",
        examples=[_example(rows[name], fresh, each) for name, each in examples.items()],
    )


def worst(table: pd.DataFrame, count: int) -> pd.DataFrame:
    """At most `count` failures, worst first, by lowest difference in any engine; two per cell."""
    pairs = table[["n_pairs_mujoco", "n_pairs_pybullet"]].sum(axis=1)
    order = table.assign(difference=lowest_difference(table), pairs=pairs)
    order = order.sort_values(["difference", "pairs", "id"], ascending=[False, False, True])
    rank = order.groupby(["complexity_cell", "difficulty_cell"]).cumcount()
    return table.loc[order.index[rank < MAX_OF_CELL][:count]]


def failure_labels(table: pd.DataFrame) -> pd.Series:
    """The label of each failure, as `egad.load` gives it."""
    ordered = table.sort_values(["difficulty_cell", "complexity_cell", "slot"])
    names = labels(ordered["complexity_cell"], ordered["difficulty_cell"])
    return pd.Series(names, index=ordered.index, dtype=object).reindex(table.index)


def reasons_of(table: pd.DataFrame) -> list[Reason]:
    """Why the detector failed at the drops where its other proposals were also tried."""
    total = int(table["n_explained"].sum())
    counts = {name: int(table[name].sum()) for name in REASONS}
    return [Reason(*REASONS[name], count, count / total) for name, count in counts.items() if total]


def lost_outcomes(fresh: pd.DataFrame) -> dict[str, tuple[int, int]]:
    """Lost fresh attempts by outcome, most frequent first, and failures at which it is usual."""
    lost = fresh[(fresh["who"] == "detector") & ~fresh["success"].astype(bool)]
    usual = Counter(next(iter(outcome_counts(rows))) for _, rows in lost.groupby("id"))
    return {name: (count, usual[name]) for name, count in outcome_counts(lost).items()}


def _verdicts(examined: pd.DataFrame) -> list[tuple[str, int, str]]:
    """Number of objects with each verdict, and its meaning."""
    counts = examined["verdict"].value_counts()
    return [
        (each.replace("_", " "), int(counts[each]), each.meaning)
        for each in ObjectVerdict
        if each in counts
    ]


def _sources(examined: pd.DataFrame) -> list[tuple[str, Rate]]:
    """Failures among the objects tried, by source."""
    tried = examined[examined["attempts"] > 0]
    return [
        (str(name), Rate(int((rows["verdict"] == "failure").sum()), len(rows)))
        for name, rows in tried.groupby("source")
    ]


def _by_who(fresh: pd.DataFrame) -> dict[str, pd.DataFrame]:
    return {
        f"{who}, {engine}": rows
        for who in WHO
        for engine, rows in fresh[fresh["who"] == who].groupby("engine")
    }


def _example(row: pd.Series, fresh: pd.DataFrame, example: Example) -> dict[str, object]:
    outcomes = lost_outcomes(fresh[fresh["id"] == row["id"]])
    return {
        "label": row["label"],
        "cell": cell_name(row["complexity_cell"], row["difficulty_cell"]),
        "complexity": row["complexity"],
        "graspability": row["graspability"],
        "picture": data_uri(example.picture),
        "engines": list(_engine_rates(row)),
        "outcomes": {name.replace("_", " "): count for name, (count, _) in outcomes.items()},
        "reasons": reasons_of(row.to_frame().T),
        "explained": row["n_explained"],
        "films": [
            (who, film.outcome.replace("_", " "), data_uri(film.content, "image/webp"))
            for who in WHO
            if (film := example.films.get(who)) is not None
        ],
        "note": example.note,
    }


def _engine_rates(row: pd.Series) -> Iterable[EngineRates]:
    for engine in ("mujoco", "pybullet"):
        if count := int(row[f"n_pairs_{engine}"]):
            won = {who: Rate(int(row[f"{who}_successes_{engine}"]), count) for who in WHO}
            yield EngineRates(
                engine, won["reference"], won["detector"], float(row[f"difference_{engine}"])
            )


def feature_chart(features: Sequence[FeatureShare]) -> str:
    """SVG of failures and solved objects along each feature, in units of the solved range."""
    with new_figure(5.4, 0.9 + 0.46 * len(features)) as drawing:
        axes = drawing.figure.add_subplot()
        axes.axvspan(0, 1, color=FAINT, lw=0)
        for number, each in enumerate(features):
            low, high = each.share.low, each.share.high
            width = max(high - low, np.finfo(float).eps)
            for values, y, color, label, size in (
                (each.solved, 0.17, SOFT, "solved", 3.0),
                (each.failures, -0.17, LINES[1], "failures", 4.5),
            ):
                x = np.clip((values - low) / width, -BEYOND, 1 + BEYOND)
                jitter = np.linspace(-0.09, 0.09, max(len(x), 1))[: len(x)]
                axes.plot(
                    x,
                    -number + y + jitter,
                    "o",
                    color=color,
                    ms=size,
                    mew=0,
                    alpha=0.55,
                    label="" if number else label,
                )
        axes.set_yticks(-np.arange(len(features)), [each.feature.title for each in features])
        axes.set(ylim=(-len(features) + 0.5, 0.5))
        axes.tick_params(axis="y", length=0)
        axes.spines[["left"]].set_visible(False)
        axes.set_xticks([0, 1], ["5 %", "95 %"])
        axes.set(xlim=(-BEYOND - 0.05, 1 + BEYOND + 0.05))
        axes.set_xlabel("quantile of the objects that the detector solves")
        drawing.figure.legend(loc="outside upper right", ncols=2, fontsize=9)
    return drawing.svg
