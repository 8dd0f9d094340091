"""The report of a run: one HTML page that needs no other file and no network.

Each section is a module of `egad.report`; this module passes it tables and settings.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import pandas as pd

from egad.measures import Attainable, MeasureParameters, attainable_graspability
from egad.report import (
    agreement,
    clutter,
    comparison,
    evaluation,
    evolution,
    grasps,
    objects,
    space_map,
    summary,
    trials,
)
from egad.report.axes import AxisPair, axis_pair
from egad.report.page import Section, report_page, section_of
from egad.report.viewer import GraspScene
from egad_workflow.config_tables import changed_parameters, settings_text
from egad_workflow.settings import Settings, select

MAX_LISTED = 100  # meshes of the user: up to this many are shown one by one, more on a map
ByGripper = Mapping[str, pd.DataFrame]
ByDetector = Mapping[str, pd.DataFrame]


@dataclass(frozen=True)
class DatasetReport:
    """Tables and pictures of one dataset; what was not made for it is absent."""

    objects: pd.DataFrame  # columns of `tables.objects.OBJECTS`
    rejected: pd.DataFrame  # of REJECTED, with the names of stages
    pictures: Mapping[str, bytes] = field(default_factory=dict)  # PNG by label
    evalset: pd.DataFrame | None = None  # `tables.evaluation.EVAL49`
    evalset_pictures: Mapping[str, bytes] = field(default_factory=dict)
    grasps: ByGripper = field(default_factory=dict)
    scales: ByGripper = field(default_factory=dict)
    size_effects: ByGripper = field(default_factory=dict)
    manifests: ByGripper = field(default_factory=dict)
    trials: Mapping[tuple[str, str], pd.DataFrame] = field(default_factory=dict)
    clutter: Mapping[str, ByDetector] = field(default_factory=dict)
    clutter_pictures: Mapping[str, Mapping[str, Sequence[bytes]]] = field(default_factory=dict)
    agreement: ByGripper = field(default_factory=dict)
    scenes: Sequence[GraspScene] = ()
    history: pd.DataFrame | None = None


@dataclass(frozen=True)
class ReportData:
    """A whole run."""

    settings: Settings  # the resolved configuration
    comparison: pd.DataFrame  # columns of `tables.objects.COMPARISON`
    datasets: Mapping[str, DatasetReport]  # reports by name of the dataset
    versions: Mapping[str, str]  # version of each program that was used


def build(report: ReportData) -> str:
    """Combine a run into one HTML page, pictures inline; what a dataset lacks is left out."""
    return report_page(_sections(report), alone=len(report.datasets) == 1)


def _sections(report: ReportData) -> Iterator[Section]:
    """All sections, in their order; those without any content are left out."""
    settings, datasets = report.settings, report.datasets
    axes, space = axis_pair(settings.measures), settings.space
    limit = attainable_graspability(select(settings, MeasureParameters))
    results = {name: _results(data, settings, axes) for name, data in datasets.items()}
    listed = {name for name, data in datasets.items() if is_listed(settings, name, data.objects)}
    mapped = {name: data for name, data in datasets.items() if name not in listed}
    summaries = {
        name: summary.DatasetSummary(
            data.objects, space, data.evalset, results[name], name in listed
        )
        for name, data in datasets.items()
    }
    yield summary.section(summaries, settings.select_eval.rows * settings.select_eval.columns)
    own = {name: data for name, data in datasets.items() if name in listed}
    yield from _objects(own, settings, axes)
    yield from _evaluation(mapped, settings, axes)
    if any(results.values()):
        protocol = settings.trials
        yield trials.section(results, attempts=protocol.attempts, lift_height=protocol.lift_height)
    yield from _clutter(datasets)
    if mapped:
        maps = {
            name: space_map.space_map(data.objects, data.pictures, space)
            for name, data in mapped.items()
        }
        yield space_map.section(maps, space, axes, limit)
        yield from _evolution(mapped, settings, axes, limit)
        yield comparison.section(report.comparison, space, limit)
    yield from _grasps(datasets, settings)
    yield from _agreement(datasets, settings)
    yield summary.left_out_section({name: data.rejected for name, data in datasets.items()})
    yield section_of(
        "parameters.html.j2",
        "Parameters",
        changed=changed_parameters(settings),
        settings=settings_text(settings),
        versions=report.versions,
    )


def is_listed(settings: Settings, name: str, objects: pd.DataFrame) -> bool:
    """Whether the objects of a dataset are shown one by one rather than on a map."""
    return settings.datasets[name].source == "meshes" and len(objects) <= MAX_LISTED


def _results(data: DatasetReport, settings: Settings, axes: AxisPair) -> dict[str, trials.Results]:
    """What the detectors achieved, by gripper."""
    tables: dict[str, dict[str, pd.DataFrame]] = {}
    for (gripper, detector), table in data.trials.items():
        if len(table):
            tables.setdefault(gripper, {})[detector] = table
    layout = settings.select_eval
    tried = trials.EvaluationSet(layout.rows, layout.columns, data.evalset, axes)
    return {gripper: trials.trial_results(each, tried) for gripper, each in tables.items()}


def _objects(
    datasets: Mapping[str, DatasetReport], settings: Settings, axes: AxisPair
) -> Iterator[Section]:
    gripper = settings.targets.grippers[0]
    views = {
        name: objects.objects_view(
            data.objects,
            data.pictures,
            axes,
            data.evalset,
            objects.GripperTables(data.scales, data.manifests, data.trials),
            data.scenes,
            settings.grippers[gripper],
        )
        for name, data in datasets.items()
    }
    if views:
        yield section_of("objects.html.j2", "Objects", views=views, gripper=gripper)


def _evolution(
    datasets: Mapping[str, DatasetReport], settings: Settings, axes: AxisPair, limit: Attainable
) -> Iterator[Section]:
    views = {
        name: view
        for name, data in datasets.items()
        if (view := evolution.evolution_view(data.objects, data.history, settings.space))
    }
    if views:
        yield section_of(
            "evolution.html.j2",
            "Evolution",
            views=views,
            space=settings.space,
            axes=axes,
            limit=limit,
            sampled=not settings.measures.graspability,
            islands=settings.schedule.islands,
        )


def _evaluation(
    datasets: Mapping[str, DatasetReport], settings: Settings, axes: AxisPair
) -> Iterator[Section]:
    layout, gripper = settings.select_eval, settings.targets.grippers[0]
    views = {
        name: evaluation.evaluation_view(
            data.evalset,
            layout.rows,
            layout.columns,
            {**data.pictures, **data.evalset_pictures},
            data.scenes,
            settings.grippers[gripper],
        )
        for name, data in datasets.items()
        if data.evalset is not None and len(data.evalset)
    }
    if views:
        percentile = None if settings.measures.graspability else settings.graspability.percentile
        yield section_of(
            "evaluation.html.j2",
            "Evaluation set",
            views=views,
            axes=axes,
            percentile=percentile,
            gripper=gripper,
        )


def _grasps(datasets: Mapping[str, DatasetReport], settings: Settings) -> Iterator[Section]:
    views = {
        name: view
        for name, data in datasets.items()
        if (view := grasps.grasp_view(data.grasps, data.size_effects))
    }
    if views:
        yield section_of(
            "grasps.html.j2",
            "Grasps",
            views=views,
            most_grasps=settings.grasp_label.grasps,
            copies=settings.robust.samples,
            size_grasps=settings.size_effect.grasps,
            size_repeats=settings.size_effect.repeats,
        )


def _clutter(datasets: Mapping[str, DatasetReport]) -> Iterator[Section]:
    found = {
        name: {
            gripper: clutter.clutter_view(
                tables, data.evalset, data.clutter_pictures.get(gripper, {})
            )
            for gripper, tables in data.clutter.items()
            if data.evalset is not None and any(len(table) for table in tables.values())
        }
        for name, data in datasets.items()
    }
    if any(found.values()):
        yield section_of("clutter.html.j2", "Cleared tables", datasets=found)


def _agreement(datasets: Mapping[str, DatasetReport], settings: Settings) -> Iterator[Section]:
    found = {
        name: {
            gripper: agreement.agreement(table, settings.select_eval.rows)
            for gripper, table in data.agreement.items()
            if len(table)
        }
        for name, data in datasets.items()
    }
    if any(found.values()):
        yield section_of(
            "agreement.html.j2",
            "Labels",
            datasets=found,
            lift_height=settings.trials.lift_height,
            hold_time=settings.trials.hold_time,
            friction=settings.quality.friction,
        )
