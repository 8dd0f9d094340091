"""Complexity and graspability of meshes, and their cells."""

import logging
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from egad._util.parameters import ScaleRule
from egad._util.progress import progress
from egad._util.workers import workers
from egad.cli import common
from egad.grippers import SUCTION
from egad.measures import MAP_RULE, MeasureMeshes
from egad_workflow.settings import Settings, select

if TYPE_CHECKING:
    import pandas as pd
    import trimesh

log = logging.getLogger(__name__)


def measure(
    meshes: common.Meshes,
    units: common.Units = None,
    gripper: Annotated[str | None, common.gripper_option("graspability.gripper")] = None,
    rule: Annotated[
        ScaleRule,
        typer.Option("--rule", help=f"scaling to the gripper; cells compare only with {MAP_RULE}"),
    ] = MAP_RULE,
    out: common.TableFile = None,
    max_candidates: common.MaxCandidates = None,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Measure complexity and graspability of meshes, and print their cells.

    `--out` also has the number of grasps, the size at which they were sampled, and how certain a
    cell is.
    """
    from egad.cli.table_files import write_frame
    from egad.cli.terminal_tables import measured
    from egad.io import check_ending, object_names
    from egad.report.axes import axis_pair
    from egad.tables.objects import MEASURED

    check_ending(out)
    options = {"--max-candidates": ("postprocess.max_candidates", max_candidates)}
    whole = common.settings_in(config, options)
    whole, name = common.gripper_in(whole, gripper or whole.graspability.gripper)
    files = object_names(common.files_in(meshes, units))
    settings = select(whole, MeasureMeshes, name)
    table = measure_files(settings, files, units, jobs, rule)
    if settings.gripper.grasps_with == SUCTION:
        table[["complexity_cell", "difficulty_cell"]] = None  # the map has no meaning for cups
    if out is not None:
        write_frame(table, MEASURED, out)
    measured(table, axis_pair(whole.measures))
    warn_of_measures(table)
    if note := incomparable(whole, name, rule):
        typer.echo(note)
    common.complain(common.reasons_in(table), len(table))


def measure_files(
    settings: MeasureMeshes,
    files: Mapping[str, Path],
    units: str | None,
    worker_count: int,
    rule: str = MAP_RULE,
) -> "pd.DataFrame":
    """Rows of `tables.objects.MEASURED` of repaired mesh files; `reason` if unusable."""
    import pandas as pd

    from egad.io import warn_of_units
    from egad.tables.objects import MEASURED

    work = partial(_row, units=units, settings=settings, rule=rule)
    with workers(min(worker_count, len(files))) as mapper:
        done = list(progress(mapper(work, files.items()), "measuring", len(files)))
    warn_of_units({row["name"]: longest for row, longest in done}, units)
    return pd.DataFrame([row for row, _ in done], columns=MEASURED.names)


def _row(
    item: tuple[str, Path], units: str | None, settings: MeasureMeshes, rule: str
) -> tuple[dict[str, Any], float]:
    """The row of a mesh file, and its longest side before repair."""
    from egad.io import use_mesh

    name, path = item
    found, longest = use_mesh(path, units, lambda mesh: measure_row(mesh, settings, rule)[1])
    row = {"reason": found} if isinstance(found, str) else {"reason": "", **found}
    return {"name": name, **row}, longest


def measure_row(
    mesh: "trimesh.Trimesh", settings: MeasureMeshes, rule: str = MAP_RULE
) -> "tuple[trimesh.Trimesh, dict[str, Any]]":
    """The repaired mesh and its row of `tables.objects.MEASURED`; RejectedError if unusable."""
    from egad.measures import cell_of, grasped_size, measure_repeatably, repaired_body

    repaired, _ = repaired_body(mesh, settings)
    solid = repaired.mesh
    if settings.measures.graspability:
        rule = "none"  # the user's own measure gets the mesh as it is
    size = grasped_size(solid, settings, rule)
    place = measure_repeatably(solid, settings, settings.postprocess.max_candidates, size.factor)
    column, row = cell_of(place.complexity, place.graspability, settings.space)
    return solid, {
        **place._asdict(),
        "complexity_cell": column,
        "difficulty_cell": row,
        "longest_side": float(solid.extents.max()),
        "rule": rule,
        "opening": settings.gripper.opening,
        "factor": size.factor,
        **dict(zip(("grasped_1", "grasped_2", "grasped_3"), size.sides, strict=True)),
        "repaired": repaired.changed,
        "shell_thickness": repaired.shell_thickness,
        "dropped_bodies": repaired.dropped_bodies,
        "dropped_volume": repaired.dropped_volume,
    }


def warn_of_measures(table: "pd.DataFrame") -> None:
    """Warn of meshes that are measured larger than they are, and call `warn_of_shapes`."""
    from egad.geometry import ENLARGED
    from egad.geometry.repair import warn_of_shapes

    larger = table[table["factor"] > ENLARGED]
    if len(larger):
        log.warning(
            "%d of %d meshes are enlarged before they are measured, for example %s by a factor of "
            "%.3g; with --rule none, egad measure keeps their real size",
            *(len(larger), len(table), larger["name"].iloc[0], larger["factor"].iloc[0]),
        )
    warn_of_shapes(table)


def incomparable(settings: Settings, gripper: str, rule: str) -> str:
    """Why cells for a gripper do not compare with the map of a configuration; empty if they do."""
    own = settings.graspability.gripper
    if settings.measures.graspability or (rule, gripper) == (MAP_RULE, own):
        return ""
    return (
        f"These cells cannot be compared with the map: they are for the rule {rule} and {gripper}, "
        f"those of the map for {MAP_RULE} and {own}."
    )
