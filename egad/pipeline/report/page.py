"""The report: one HTML page that needs no other file and no network."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from egad.pipeline.config.settings import Settings
from egad.pipeline.report.config_tables import entry_tables, parameter_tables
from egad.report import figures, maps, summary
from egad.report.agreement_view import Agreement, agreement
from egad.report.axes import axis_pair
from egad.report.data import DatasetReport
from egad.report.dataset_maps import dataset_maps
from egad.report.environment import environment
from egad.report.filling import filling_curves, filling_film
from egad.report.size_chart import size_chart
from egad.report.trial_views import Results, Set, results
from egad.report.viewer import viewer_data


@dataclass(frozen=True)
class ReportData:
    """A whole run.

    Attributes:
        settings: The resolved configuration.
        comparison: Columns of `tables.objects.COMPARISON`.
        datasets: Reports by name of the dataset.
        versions: Version of each program that took part.
    """

    settings: Settings
    comparison: pd.DataFrame
    datasets: Mapping[str, DatasetReport]
    versions: Mapping[str, str]


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
    results: dict[str, Results]
    agreement: dict[str, Agreement]
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
        results=_results(data, settings),
        agreement={
            gripper: agreement(table, settings.select_eval.rows)
            for gripper, table in data.agreement.items()
            if len(table)
        },
        regrading=summary.regrading(data.objects, settings.space),
        curves=_figure(filling_curves({name: history})) if history is not None else "",
        film=maps.data_uri(filling_film(history, settings.space), "image/gif")
        if history is not None
        else "",
        rejections=summary.rejection_counts(data.rejected),
        rejected=data.rejected.sort_values(["stage", "id"]).to_dict("records"),
    )


def _results(data: DatasetReport, settings: Settings) -> dict[str, Results]:
    """What the detectors achieved, by gripper."""
    tables: dict[str, dict[str, pd.DataFrame]] = {}
    for (gripper, policy), trials in data.trials.items():
        if len(trials):
            tables.setdefault(gripper, {})[policy] = trials
    chosen, axes = data.evalset, axis_pair(settings.axes)
    tried = Set(settings.select_eval.rows, settings.select_eval.columns, chosen, axes)
    return {gripper: results(found, tried) for gripper, found in tables.items()}


def _figure(svg: str) -> str:
    return maps.data_uri(svg.encode(), "image/svg+xml")
