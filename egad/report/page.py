"""The report: one HTML page that needs no other file and no network."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from egad.report import figures, maps, summary
from egad.report.axes import axis_pair
from egad.report.data import DatasetReport, ReportData
from egad.report.dataset_maps import dataset_maps
from egad.report.environment import environment
from egad.report.filling import filling_curves, filling_film
from egad.report.parameters import entry_tables, parameter_tables
from egad.report.size_chart import size_chart
from egad.report.viewer import viewer_data
from egad.settings import Settings
from egad.trials.statistics import Rate, trial_grid

__all__ = ["DatasetReport", "ReportData", "build"]


@dataclass(frozen=True)
class TrialView:
    """Attempts of one gripper and policy."""

    gripper: str
    policy: str
    rate: Rate
    objects: int
    outcomes: dict[str, int]
    heat_map: str


@dataclass(frozen=True)
class DatasetView:
    """One dataset as the templates show it; figures are addresses, empty if there is none."""

    name: str
    source: str
    numbers: summary.Row
    space_map: maps.SpaceMap
    evaluation: list[list[maps.Place]]
    chosen: int
    grasps: list[summary.Row]
    grasp_figure: str
    size_figures: dict[str, str]
    viewer: dict[str, Any] | None
    scales: list[summary.Row]
    trials: list[TrialView]
    outcome_figure: str
    regrading: summary.Row | None
    curves: str
    film: str
    rejections: list[summary.Row]
    rejected: Sequence[Mapping[Any, Any]]


def build(report: ReportData) -> str:
    """Put a run together as one HTML page.

    Args:
        report: Tables, pictures, settings and versions; what a dataset lacks is left out.

    Returns:
        The text of the page: the same for the same report. Pictures and figures are inline.
    """
    axes = axis_pair(report.settings.axes)
    views = [_view(name, data, report.settings) for name, data in report.datasets.items()]
    objects = {name: data.objects for name, data in report.datasets.items()}
    return (
        environment()
        .get_template("page.html.j2")
        .render(
            settings=report.settings,
            axes=axes,
            views=views,
            comparison=report.comparison.to_dict("records"),
            published=summary.PUBLISHED.to_dict("records"),
            dataset_maps=_figure(dataset_maps(objects, report.settings.space, axes)),
            comparison_figure=_figure(figures.comparison_chart(report.comparison)),
            parameters=parameter_tables(report.settings),
            entries=entry_tables(report.settings),
            versions=report.versions,
        )
    )


def _view(name: str, data: DatasetReport, settings: Settings) -> DatasetView:
    grasps = {key: table for key, table in data.grasps.items() if len(table)}
    trials = {key: table for key, table in data.trials.items() if len(table)}
    bars = {f"{gripper}, {policy}": table for (gripper, policy), table in trials.items()}
    grippers = list(dict.fromkeys([*data.scales, *data.manifests]))
    history = data.history
    return DatasetView(
        name=name,
        source=settings.datasets[name].source,
        numbers=summary.space_numbers(data.objects, settings.space),
        space_map=maps.space_map(data, settings.space),
        evaluation=maps.evaluation_grid(data, settings.select_eval),
        chosen=0 if data.evalset is None else len(data.evalset),
        grasps=[summary.grasp_numbers(key, table) for key, table in grasps.items()],
        grasp_figure=_figure(figures.grasp_distributions(grasps)) if grasps else "",
        size_figures={
            gripper: _figure(size_chart(table))
            for gripper, table in data.size_effects.items()
            if len(table)
        },
        viewer=viewer_data(data.scenes, settings.grippers[settings.targets.grippers[0]])
        if data.scenes
        else None,
        scales=[summary.scale_numbers(gripper, data) for gripper in grippers],
        trials=[_trial_view(key, table, data, settings) for key, table in trials.items()],
        outcome_figure=_figure(figures.outcome_bars(bars)) if bars else "",
        regrading=summary.regrading(data.objects, settings.space),
        curves=_figure(filling_curves({name: history})) if history is not None else "",
        film=maps.data_uri(filling_film(history, settings.space), "image/gif")
        if history is not None
        else "",
        rejections=summary.rejection_counts(data.rejected),
        rejected=data.rejected.sort_values(["stage", "id"]).to_dict("records"),
    )


def _trial_view(
    key: tuple[str, str], trials: pd.DataFrame, data: DatasetReport, settings: Settings
) -> TrialView:
    rows, columns = settings.select_eval.rows, settings.select_eval.columns
    grid = trial_grid(trials, rows, columns)
    chosen = trials if data.evalset is None else data.evalset
    present, axes = set(chosen["label"]), axis_pair(settings.axes)
    heat_map = figures.trial_heat_map(grid, rows, columns, present, axes)
    outcomes = summary.outcome_counts(trials)
    return TrialView(*key, grid.overall, len(grid.cells), outcomes, _figure(heat_map))


def _figure(svg: str) -> str:
    return maps.data_uri(svg.encode(), "image/svg+xml")
