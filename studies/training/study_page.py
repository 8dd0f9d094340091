"""The page about networks that were trained on different object sets."""

import json
import string
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from network_statistics import (
    TEST,
    SetComparison,
    Spread,
    by_name,
    compare_sets,
    mean_interval,
    network_rates,
    pooled_spread,
    set_or_detector,
)
from numpy.typing import NDArray
from study import SET_SECTIONS, Network, PageSettings, TrainingSet
from study_charts import Row, learning_chart, success_chart

from egad.bench.stats import Mean, mean_rate
from egad.evalset import cell_of_label
from egad.report.colors import ink_on
from egad.report.page import render_template, svg_uri
from egad.report.trial_charts import outcome_chart, rate_color
from egad.tables import parquet

NOISE_TITLES = {"none": "no noise", "stereo": "stereo noise"}
WIDTHS = {"to 20 mm": 0.02, "20 to 45 mm": 0.045, "above 45 mm": np.inf}  # upper ends, metres
Floats = NDArray[np.float64]
Rates = dict[tuple[str, str, str, str], dict[str, Floats]]


@dataclass(frozen=True)
class Images:
    """The rendered images of a training set.

    Attributes:
        objects: Dataset and id of the objects that networks are trained on: of the split train.
        count: How many images show them.
    """

    objects: frozenset[tuple[str, str]]
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
class Results:
    """All that was made.

    Attributes:
        settings: What was asked for.
        trials: Columns of `study_tables.COMPARED`.
        cleared: Columns of `study_tables.CLEARED`.
        widths: Shortest side of each object of a test as it is tried, metres, by dataset and label.
        images: By training set, of those that are trained on.
        trainings: By network, of the same sets.
    """

    settings: PageSettings
    trials: pd.DataFrame
    cleared: pd.DataFrame
    widths: Mapping[str, Mapping[str, float]]
    images: Mapping[str, Images]
    trainings: Mapping[Network, Training]


@dataclass(frozen=True)
class SetView:
    """A training set, or another detector, in all tests of a dataset.

    Attributes:
        rows: Its success, by column.
        objects: The same with the interval by objects, for tests with single objects.
    """

    rows: dict[str, Row]
    objects: dict[str, Mean]


@dataclass(frozen=True)
class NoiseView:
    """Single objects with one kind of noise.

    Attributes:
        name: Name of the noise.
        outcomes: Address of a figure.
        parts: Success by name and then row, column and width: value, color, color of the text.
    """

    name: str
    outcomes: str
    parts: dict[str, dict[str, tuple[float, str, str]]]


@dataclass(frozen=True)
class TestView:
    """All tests with the objects of a dataset.

    Attributes:
        name: Name of the dataset.
        objects: How many there are.
        seen: How many of them networks were trained on, by training set.
        sets: By name of the set or other detector.
        spreads: By column: standard deviation of each set of more than two networks, by name, and
            of all sets together.
        noises: Kinds of noise of the depth images.
    """

    name: str
    objects: int
    seen: dict[str, int]
    sets: dict[str, SetView]
    spreads: dict[str, tuple[dict[str, Spread], Spread | None]]
    noises: list[NoiseView]

    @property
    def columns(self) -> list[str]:
        """What is tested and measured."""
        return list(self.spreads)


@dataclass(frozen=True)
class Comparisons:
    """The pre-registered comparisons."""

    rows: list[SetComparison]
    noises: Mapping[str, str]


def page(results: Results) -> str:
    """The page about the results of a study: HTML that needs no other file."""
    settings = results.settings
    asked = settings.plan
    rates = rates_by_test(results.trials, results.cleared)
    shown = panels(rates, set(results.images))
    curves = learning_curves(shown, results.images, asked.curves)
    return render_template(
        "study.html.j2",
        Path(__file__).parent,
        base="document.html.j2",
        settings=settings,
        descriptions={key: describe(asked.training_sets[key]) for key in asked.sets},
        images=results.images,
        trainings=results.trainings,
        success_figure=svg_uri(success_chart(shown)),
        comparisons=Comparisons(compare_sets(results.trials, asked.comparisons), NOISE_TITLES),
        curves=[svg_uri(chart) for chart in curves.values()],
        tests=[_test(name, rates, results) for name in asked.tests],
        widths=list(WIDTHS),
    )


def describe(training_set: TrainingSet) -> str:
    """What a training set consists of, in words, with names in backticks."""
    if training_set.weights:
        return f"given weights, `{training_set.weights}`, without training"
    if training_set.images:
        source = "images of " + ", ".join(f"`{name}`" for name in training_set.images)
    else:
        source = f"dataset `{training_set.dataset}`"
    changes = [
        f"`{section}.{key}: {json.dumps(value)}`"
        for section in SET_SECTIONS
        for key, value in getattr(training_set, section).items()
    ]
    return "; ".join([source, *changes])


def rates_by_test(trials: pd.DataFrame, cleared: pd.DataFrame) -> Rates:
    """Success of each network, by test and then by training set or other detector.

    Args:
        trials: Columns of `study_tables.COMPARED`.
        cleared: Columns of `study_tables.CLEARED`.
    """
    found: Rates = {}
    groups = network_rates(trials, cleared).groupby(TEST, sort=False)
    for (test, scene, noise, measure), rows in groups:
        found[str(test), str(scene), str(noise), str(measure)] = by_name(rows)
    return found


def _rows(rates: Mapping[str, Floats], trained: set[str]) -> dict[str, Row]:
    """Rows of a chart, with intervals by the standard deviation of all trained sets together."""
    spread = pooled_spread(values for name, values in rates.items() if name in trained)
    return {
        name: Row(
            list(map(float, values)),
            name in trained,
            mean_interval(values, spread if name in trained else None),
        )
        for name, values in rates.items()
    }


def panels(
    rates: Rates, trained: set[str], *, clutter: bool = False, measure: str = "success"
) -> dict[str, dict[str, Row]]:
    """A panel of the chart for each dataset, kind of scene and noise.

    Args:
        rates: From `rates_by_test`.
        trained: Names of the sets whose networks were trained; the others are given weights or
            other detectors, without an interval.
        clutter: Whether of scenes of several objects, rather than of single objects.
        measure: `success`, or for clutter `cleared`.
    """
    return {
        ", ".join([test, *[scene] * clutter, NOISE_TITLES[noise]]): _rows(found, trained)
        for (test, scene, noise, measured), found in rates.items()
        if (scene != "single") == clutter and measured == measure
    }


def learning_curves(
    shown: Mapping[str, Mapping[str, Row]],
    images: Mapping[str, Images],
    curves: Mapping[str, Sequence[str]],
) -> dict[str, str]:
    """Learning curves, SVG texts.

    Args:
        shown: Success by test and then by set, from `panels`.
        images: Images of the sets, by name.
        curves: Names of the sets of a curve, by what its size counts: `objects` or `images`. A
            curve without sets is left out.
    """
    sizes = {
        "objects": {name: len(each.objects) for name, each in images.items()},
        "images": {name: each.count for name, each in images.items()},
    }
    return {
        kind: learning_chart(
            {
                title: [(sizes[kind][name], found[name]) for name in names]
                for title, found in shown.items()
            },
            f"training {kind}",
        )
        for kind, names in curves.items()
        if names
    }


def _test(name: str, rates: Rates, results: Results) -> TestView:
    asked = results.settings.plan
    tried = results.trials[results.trials["test"] == name]
    columns = {_title(*key[1:]): found for key, found in rates.items() if key[0] == name}
    by_noise = {
        str(noise): attempts_by_set(own) for noise, own in tried.groupby("noise", sort=False)
    }
    names = [*asked.sets, *asked.references]
    known = {(name, each) for each in tried["id"]}
    return TestView(
        name=name,
        objects=tried["id"].nunique(),
        seen={key: len(known & found.objects) for key, found in results.images.items()},
        sets=_set_views(names, columns, by_noise, set(results.images)),
        spreads={title: _spreads(found) for title, found in columns.items()},
        noises=[
            NoiseView(
                NOISE_TITLES[noise],
                svg_uri(outcome_chart(own)),
                {key: _colored(by_part(own[key], results.widths[name])) for key in names},
            )
            for noise, own in by_noise.items()
        ],
    )


def _set_views(
    names: Iterable[str],
    columns: Mapping[str, dict[str, Floats]],
    attempts: Mapping[str, dict[str, pd.DataFrame]],
    trained: set[str],
) -> dict[str, SetView]:
    """Sets and other detectors by name.

    Args:
        names: Theirs.
        columns: Success by title of the test.
        attempts: At single objects, by noise and name.
        trained: Names of the sets whose networks were trained.
    """
    rows = {title: _rows(found, trained) for title, found in columns.items()}
    single = {_title("single", noise, "success"): own for noise, own in attempts.items()}
    return {
        name: SetView(
            {title: found[name] for title, found in rows.items()},
            {title: mean_rate(own[name]) for title, own in single.items()},
        )
        for name in names
    }


def _title(scene: str, noise: str, measure: str) -> str:
    """What is tested and measured, as the head of a column."""
    what = f"{scene}, {measure}" if scene != "single" else scene
    return f"{what}, {NOISE_TITLES[noise]}"


def attempts_by_set(rows: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Attempts by training set or other detector."""
    return {str(name): own for name, own in rows.groupby(set_or_detector(rows), sort=False)}


def _spreads(rates: Mapping[str, Floats]) -> tuple[dict[str, Spread], Spread | None]:
    several = {name: values for name, values in rates.items() if len(values) > 2}
    each = {name: pooled_spread([values]) for name, values in several.items()}
    return {name: found for name, found in each.items() if found}, pooled_spread(rates.values())


def _colored(parts: Mapping[str, float]) -> dict[str, tuple[float, str, str]]:
    """Success of parts with colors of the cell and of its text."""
    colors = {key: rate_color(value) for key, value in parts.items()}
    return {key: (value, colors[key], ink_on(colors[key])) for key, value in parts.items()}


def by_part(rows: pd.DataFrame, widths: Mapping[str, float]) -> dict[str, float]:
    """Success by row and column of the evaluation set and by the width of the object.

    Args:
        rows: Attempts, with the columns `label` and `success`.
        widths: Metres, by label.
    """
    cells = [cell_of_label(label) for label in rows["label"]]
    sides = [widths[label] for label in rows["label"]]
    index = np.digitize(sides, list(WIDTHS.values()), right=True)
    by_width = _means(rows, [list(WIDTHS)[number] for number in index])
    return {
        **_means(rows, [string.ascii_uppercase[row] for row, _ in cells]),
        **_means(rows, [str(column) for _, column in cells]),
        **{name: by_width[name] for name in WIDTHS if name in by_width},
    }


def _means(rows: pd.DataFrame, groups: list[str]) -> dict[str, float]:
    means = rows["success"].groupby(np.array(groups)).mean()
    return {str(key): float(value) for key, value in means.items()}


def object_sides(evaluation: pd.DataFrame, scales: pd.DataFrame) -> dict[str, list[float]]:
    """The sides of each object of an evaluation set as it is tried, by its label.

    Args:
        evaluation: Columns of `tables.evaluation.EVAL49`.
        scales: Columns of `tables.grasping.SCALES`.

    Returns:
        Sides of its smallest box, metres, the shortest first.
    """
    sides = scales.set_index("label")[["after_1", "after_2", "after_3"]]
    return {
        row["label"]: sides.loc[row["object_label"]].to_list()
        for row in parquet.records(evaluation)
    }
