"""The page about networks that were trained on different object sets."""

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from egad.pipeline.config.sections import TrainingSet
from egad.pipeline.config.stage_settings import TrainingStudyReport
from egad.pipeline.config.training_study import Network
from egad.report.drawing import svg_uri
from egad.report.page import render_template
from egad.report.training import score_chart, set_colors, success_chart, training_curves
from egad.report.trial_charts import outcome_chart, rate_bars, trial_heat_map
from egad.report.trials import EvaluationSet
from egad.stats import (
    Mean,
    SeedVariance,
    SetPair,
    SetRate,
    TestAttempts,
    TrialGrid,
    by_set,
    by_test,
    references,
    seed_variance,
    set_pairs,
    trial_grid,
)


@dataclass(frozen=True)
class Images:
    """The rendered images of a training set.

    Attributes:
        objects: Ids of the objects that networks are trained on: those of the split train.
        count: How many images show them.
    """

    objects: frozenset[str]
    count: int


@dataclass(frozen=True)
class Training:
    """How a network was trained.

    Attributes:
        history: Columns of `tables.training.HISTORY`.
        score: Columns of `tables.training.SCORE`, by name.
    """

    history: pd.DataFrame
    score: Mapping[str, float]

    @property
    def rate(self) -> float:
        """Fraction of the test images in which its grasp is correct; NaN if none counts."""
        right, count = self.score["n_correct"], self.score["n_images"]
        return right / count if count else float("nan")

    @property
    def last(self) -> pd.Series:
        """The last epoch."""
        return self.history.iloc[-1]


@dataclass(frozen=True)
class Study:
    """All that was made.

    Attributes:
        settings: What was asked for.
        table: Columns of `tables.training.COMPARED`.
        tests: The evaluation sets, by their dataset.
        images: By training set, of those that are trained on.
        trainings: By network, of the same sets.
    """

    settings: TrainingStudyReport
    table: pd.DataFrame
    tests: Mapping[str, EvaluationSet]
    images: Mapping[str, Images]
    trainings: Mapping[Network, Training]


@dataclass(frozen=True)
class SetView:
    """A training set in a test; the heat map is an address.

    Attributes:
        name: Of the set.
        rate: Its success.
        ends: Success in the first and in the last row: the easiest and the hardest objects.
        seen: Objects of the test that its networks were trained on.
        heat_map: Success of each object, all networks together.
    """

    name: str
    rate: SetRate
    ends: tuple[Mean, Mean]
    seen: int
    heat_map: str


@dataclass(frozen=True)
class TestView:
    """A test; figures are addresses, empty if there is none."""

    name: str
    objects: int
    sets: list[SetView]
    references: dict[str, Mean]
    pairs: list[SetPair]
    noise: SeedVariance | None
    rows_figure: str
    columns_figure: str
    outcome_figure: str
    score_figure: str


def page(study: Study) -> str:
    """The page about a study: HTML that needs no other file."""
    settings, tests = study.settings, by_test(study.table)
    sets = settings.training_study.sets
    curves = training_curves(_histories(study), set_colors(sets)) if study.trainings else ""
    return render_template(
        "training_study",
        settings=settings,
        descriptions={key: describe(settings.training_sets[key]) for key in sets},
        images=study.images,
        trainings=study.trainings,
        success_figure=svg_uri(success_chart(tests)),
        curves=svg_uri(curves),
        tests=[_test(name, tried, study) for name, tried in tests.items()],
    )


def describe(training_set: TrainingSet) -> str:
    """What a training set consists of, in words; a name stands between backticks."""
    if training_set.weights:
        return f"given weights, `{training_set.weights}`, without training"
    low, high = training_set.complexity
    objects = "all objects" if (low, high) == (0, 1) else f"complexity ranks {low:g} to {high:g}"
    if training_set.subset < 1:
        objects += f", a random sample of {training_set.subset:.1%}"
    left_out = ", without its evaluation set" if training_set.hold_out else ""
    return f"dataset `{training_set.dataset}`, {objects}{left_out}"


def _test(name: str, tried: TestAttempts, study: Study) -> TestView:
    area = study.tests[name]
    sets = by_set(tried.rows)
    grids = {key: trial_grid(rows, area.rows, area.columns) for key, rows in sets.items()}
    rows = {key: [*grid.rows, grid.overall] for key, grid in grids.items()}
    columns = {key: [*grid.columns, grid.overall] for key, grid in grids.items()}
    digits = [str(column) for column in range(area.columns)]
    points = _points(tried.sets, study)
    return TestView(
        name=name,
        objects=tried.rows["id"].nunique(),
        sets=[_set(key, name, tried, grid, study) for key, grid in grids.items()],
        references=tried.references,
        pairs=set_pairs(sets),
        noise=seed_variance(tried.sets),
        rows_figure=svg_uri(rate_bars(rows)),
        columns_figure=svg_uri(rate_bars(columns, digits)),
        outcome_figure=svg_uri(outcome_chart({**sets, **references(tried.rows)})),
        score_figure=svg_uri(score_chart(points, set_colors(list(tried.sets)))) if points else "",
    )


def _set(name: str, test: str, tried: TestAttempts, grid: TrialGrid, study: Study) -> SetView:
    area, table = study.tests[test], tried.rows
    present = set((table if area.objects is None else area.objects)["label"])
    return SetView(
        name=name,
        rate=tried.sets[name],
        ends=(grid.rows[0], grid.rows[-1]),
        seen=_seen(name, test, set(table["id"]), study),
        heat_map=svg_uri(trial_heat_map(grid, area.rows, area.columns, present, area.axes)),
    )


def _seen(name: str, test: str, ids: set[str], study: Study) -> int:
    """Objects of a test that the networks of a set were trained on; ids are those of a dataset."""
    same = study.settings.training_sets[name].dataset == test
    return len(ids & study.images[name].objects) if same else 0


def _points(rates: Mapping[str, SetRate], study: Study) -> dict[str, list[tuple[float, float]]]:
    """Score and success of the networks that were trained, by training set."""
    points: dict[str, list[tuple[float, float]]] = {}
    for network, training in study.trainings.items():
        success = rates[network.training_set].each[network.seed].value
        points.setdefault(network.training_set, []).append((training.rate, success))
    return points


def _histories(study: Study) -> dict[str, list[pd.DataFrame]]:
    histories: dict[str, list[pd.DataFrame]] = {}
    for network, training in study.trainings.items():
        histories.setdefault(network.training_set, []).append(training.history)
    return histories
