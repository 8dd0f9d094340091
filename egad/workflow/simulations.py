"""Work that stages run in a separate process, to survive a crash of the physics engine."""

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import pandas as pd
import trimesh

from egad.bench import Round, run_attempts, try_naive_grasps
from egad.bench.clearing import Cleared, open_table
from egad.config.stages import ClearedTables, NaiveGrasps, SimulatedLabels, SimulatedTrials
from egad.detectors import IN_SCENES, LABELS, Detector, Labels, check_views_will_do, opened
from egad.errors import RejectedError, UserError
from egad.geometry import Material, simulation_object
from egad.io import read_mesh
from egad.sim import (
    LabelTrialParameters,
    Model,
    SimulatedGrasp,
    chosen_grasps,
    execute_labelled_grasps,
    model_of,
    simulate_labels,
    with_simulated_labels,
)
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.grasping import GRASPS
from egad.tables.outcomes import Outcome
from egad.workflow.bundled import model_in, rows_by_id

log = logging.getLogger(__name__)
Task = tuple[Mapping[str, Any], pd.DataFrame]


@contextmanager
def open_trials(
    settings: SimulatedTrials, bundle: Path, grasps: Path | None
) -> Iterator[Callable[[Mapping[str, Any]], pd.DataFrame]]:
    """A function that runs all attempts of an object, given its row in the bundle."""
    with open_detector(settings, grasps) as detector_of:

        def attempts(row: Mapping[str, Any]) -> pd.DataFrame:
            detect = detector_of(row["id"])
            return run_attempts(model_in(bundle, row), row["label"], row["id"], detect, settings)

        yield attempts


@contextmanager
def open_detector(
    settings: SimulatedTrials, grasps: Path | None
) -> Iterator[Callable[[str], Detector | Labels]]:
    """A function that returns the detector of an object by its id, valid within the context."""
    config = settings.detector
    if config.detector == "labels":
        yield _labels(grasps)
        return
    if config.detector in IN_SCENES:
        check_views_will_do(IN_SCENES[config.detector])
    with opened(config, settings.trials.planning_time) as detect:
        yield lambda _: detect


def _labels(grasps: Path | None) -> Callable[[str], Labels]:
    if grasps is None:
        raise UserError("the detector `labels` needs the table of labelled grasps")
    table = parquet.read(grasps, GRASPS)
    return lambda object_id: Labels(table[table["id"] == object_id])


@contextmanager
def open_clutter(
    settings: ClearedTables, bundle: Path, grasps: Path | None
) -> Iterator[Callable[[Round], Cleared]]:
    """A function that lets the detector clear one table of objects of a bundle."""
    known = rows_by_id(bundle)
    by_id = {} if grasps is None else dict(list(parquet.read(grasps, GRASPS).groupby("id")))
    none = parquet.empty(GRASPS)
    if settings.detector.detector == LABELS and grasps is None:
        raise UserError("the detector `labels` needs the table of labelled grasps")
    model = cache(lambda name: model_in(bundle, known[name]))
    with open_table(
        settings.detector, model, lambda name: by_id.get(name, none), settings
    ) as clear:
        yield clear


@contextmanager
def open_agreement(
    settings: LabelTrialParameters, bundle: Path
) -> Iterator[Callable[[Task], pd.DataFrame]]:
    """A function that executes grasps of an object, given its row in the bundle and the grasps."""

    def carry_out(task: Task) -> pd.DataFrame:
        row, sample = task
        model = model_in(bundle, row)
        return execute_labelled_grasps(model, row["label"], row["id"], sample, settings)

    yield carry_out


@contextmanager
def open_labels(
    settings: SimulatedLabels, convex_parts: Path, meshes: Path
) -> Iterator[Callable[[pd.DataFrame], pd.DataFrame]]:
    """A function that adds simulated labels to the grasps of an object."""
    parts = dict(iter(parquet.read(convex_parts, CONVEX_PARTS).groupby("label")))

    def simulate(rows: pd.DataFrame) -> pd.DataFrame:
        label = rows["label"].iloc[0]
        mesh = _read(meshes / f"{label}.obj")
        if label not in parts:
            log.warning("%s cannot be simulated: it has no convex parts", label)
            return failed_labels(rows, settings, Outcome.FAILED)
        return simulate_labels(_model(mesh, settings.material, parts[label]), rows, settings)

    yield simulate


@contextmanager
def open_naive_grasps(
    settings: NaiveGrasps, convex_parts: Path, meshes: Path
) -> Iterator[Callable[[Mapping[str, Any]], pd.DataFrame]]:
    """A function that tries naive grasps of an object, given its label and id."""
    parts = dict(iter(parquet.read(convex_parts, CONVEX_PARTS).groupby("label")))

    def attempt(row: Mapping[str, Any]) -> pd.DataFrame:
        mesh = _read(meshes / f"{row['label']}.obj")
        model = _model(mesh, settings.material, parts[row["label"]])
        return try_naive_grasps(model, row["id"], settings)

    yield attempt


def _model(mesh: trimesh.Trimesh, material: Material, parts: pd.DataFrame) -> Model:
    """A scaled object with the convex parts of a table."""
    made = simulation_object(mesh, material.density, parts)
    return model_of(made.mesh, made.parts, made.physics, made.volume_error)


def _read(path: Path) -> trimesh.Trimesh:
    """A mesh written by an earlier stage: if it cannot be read, the folder is damaged."""
    try:
        return read_mesh(path, "m")
    except RejectedError as reason:
        raise UserError(f"{path}: {reason}") from reason


def failed_labels(rows: pd.DataFrame, settings: SimulatedLabels, outcome: Outcome) -> pd.DataFrame:
    """The grasps of an object for which no grasp could be simulated."""
    chosen = chosen_grasps(rows, settings)
    return with_simulated_labels(rows, chosen, [SimulatedGrasp(outcome)] * len(chosen), settings)
