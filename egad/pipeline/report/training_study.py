"""The page about networks that were trained on different objects, with its charts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd
from matplotlib.axes import Axes

from egad.learning.model_card import taken
from egad.pipeline.config.sections import TrainingSet
from egad.pipeline.config.stage_settings import DiversityReport
from egad.pipeline.config.training_study import Network
from egad.report.environment import environment
from egad.report.heat_map import trial_heat_map
from egad.report.maps import data_uri
from egad.report.style import INK, LINES, SOFT, drawn
from egad.report.trial_figures import outcome_bars, side_by_side
from egad.report.trial_views import Set
from egad.stats.rates import Mean, trial_grid
from egad.stats.training_study import (
    Luck,
    SetPair,
    SetRate,
    Tried,
    by_set,
    by_test,
    luck,
    references,
    set_pairs,
)


@dataclass(frozen=True)
class Images:
    """The rendered images of a training set.

    Attributes:
        learnt: Ids of the objects that networks learn from: those of the split train.
        train: How many images they learn from.
    """

    learnt: frozenset[str]
    train: int


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
        """The part of the test images in which its grasp is right; NaN if none counts."""
        right, count = self.score["right"], self.score["count"]
        return right / count if count else float("nan")

    @property
    def taken(self) -> pd.Series:
        """The epoch whose weights were taken."""
        return taken(self.history)


@dataclass(frozen=True)
class Experiment:
    """All that was made.

    Attributes:
        settings: What was asked for.
        table: Columns of `tables.training.COMPARED`.
        tests: The evaluation sets, by their dataset.
        images: By training set, of those that are trained on.
        trainings: By network, of the same sets.
    """

    settings: DiversityReport
    table: pd.DataFrame
    tests: Mapping[str, Set]
    images: Mapping[str, Images]
    trainings: Mapping[Network, Training]


@dataclass(frozen=True)
class SetView:
    """A training set in a test; the heat map is an address.

    Attributes:
        name: Of the set.
        rate: Its success.
        ends: Success in the first and in the last row: the easiest and the hardest objects.
        seen: Objects of the test that its networks learnt from.
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
    luck: Luck | None
    rows_figure: str
    columns_figure: str
    outcome_figure: str
    score_figure: str


def page(found: Experiment) -> str:
    """The page about the experiment: HTML that needs no other file."""
    tests = by_test(found.table)
    inks = colours(found.settings.diversity.sets)
    template = environment().get_template("training_study.html.j2")
    return template.render(
        settings=found.settings,
        described={
            key: described(found.settings.training_sets[key])
            for key in found.settings.diversity.sets
        },
        images=found.images,
        trainings=found.trainings,
        success_figure=_figure(success_chart(tests)),
        curves=_figure(training_curves(_histories(found), inks)) if found.trainings else "",
        tests=[_test(name, tried, found) for name, tried in tests.items()],
    )


def described(training_set: TrainingSet) -> str:
    """What a training set consists of, in words; a name stands between backticks."""
    if training_set.weights:
        return f"given weights, `{training_set.weights}`: nothing was trained"
    low, high = training_set.complexity
    part = "all objects" if (low, high) == (0, 1) else f"ranks {low:g} to {high:g} in complexity"
    if training_set.part < 1:
        part += f", of these {training_set.part:.1%} drawn by chance"
    kept = ", but for its evaluation set" if training_set.hold_out else ""
    return f"dataset `{training_set.dataset}`, {part}{kept}"


def _test(name: str, tried: Tried, found: Experiment) -> TestView:
    table, area = tried.rows, found.tests[name]
    sets = by_set(table)
    grids = {key: trial_grid(rows, area.rows, area.columns) for key, rows in sets.items()}
    present = set((table if area.chosen is None else area.chosen)["label"])
    ids = set(table["id"])
    views = [
        SetView(
            name=key,
            rate=tried.sets[key],
            ends=(grid.rows[0], grid.rows[-1]),
            seen=_seen(key, name, ids, found),
            heat_map=_figure(trial_heat_map(grid, area.rows, area.columns, present, area.axes)),
        )
        for key, grid in grids.items()
    ]
    rows = {key: [*grid.rows, grid.overall] for key, grid in grids.items()}
    columns = {key: [*grid.columns, grid.overall] for key, grid in grids.items()}
    points = _points(tried.sets, found)
    return TestView(
        name=name,
        objects=len(ids),
        sets=views,
        references=tried.references,
        pairs=set_pairs(sets),
        luck=luck(tried.sets),
        rows_figure=_figure(side_by_side(rows)),
        columns_figure=_figure(side_by_side(columns, [str(i) for i in range(area.columns)])),
        outcome_figure=_figure(outcome_bars({**sets, **references(table)})),
        score_figure=_figure(score_chart(points, colours(list(tried.sets)))) if points else "",
    )


def _seen(name: str, test: str, ids: set[str], found: Experiment) -> int:
    """How many objects of a test the networks of a set learnt from; ids are those of a dataset."""
    same = found.settings.training_sets[name].dataset == test
    return len(ids & found.images[name].learnt) if same else 0


def _points(
    rates: Mapping[str, SetRate], found: Experiment
) -> dict[str, list[tuple[float, float]]]:
    """Score and success of the networks that were trained, by training set."""
    points: dict[str, list[tuple[float, float]]] = {}
    for network, training in found.trainings.items():
        success = rates[network.training_set].each[network.seed].value
        points.setdefault(network.training_set, []).append((training.rate, success))
    return points


def _histories(found: Experiment) -> dict[str, list[pd.DataFrame]]:
    histories: dict[str, list[pd.DataFrame]] = {}
    for network, training in found.trainings.items():
        histories.setdefault(network.training_set, []).append(training.history)
    return histories


def _figure(svg: str) -> str:
    return data_uri(svg.encode(), "image/svg+xml")


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
