"""Tools that measure meshes: complexity, difficulty, similarity, position in the space."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad._util.parameters import SCALE_RULES
from egad.errors import UserError, check_name
from egad.measures import MAP_RULE
from egad.pipeline.cli.common import (
    CORES,
    TOOL,
    Config,
    Jobs,
    Meshes,
    Rule,
    Units,
    app,
    changed,
    files_in,
    settings_in,
)

if TYPE_CHECKING:
    import pandas as pd

TableFile = Annotated[Path | None, typer.Option(help="table to write: .parquet or .csv")]
MaxCandidates = Annotated[
    int | None,
    typer.Option(
        min=1, help="most candidate grasps for the difficulty; default: as in the configuration"
    ),
]
Bases = Annotated[
    str | None,
    typer.Option(help="even, or scan as in the original program; default: as in the configuration"),
]
Among = Annotated[
    Path,
    typer.Option("--in", help="archive.parquet, `released`, or folder of a dataset"),
]
PageFile = Annotated[
    list[Path], typer.Option(help="file to write: .html, .parquet or .csv; may be repeated")
]


@app.command(rich_help_panel=TOOL)
def measure(
    meshes: Meshes,
    units: Units = None,
    gripper: Annotated[
        str | None,
        typer.Option(help="gripper that difficulty is for; default: as in the configuration"),
    ] = None,
    rule: Rule = MAP_RULE,
    out: TableFile = None,
    max_candidates: MaxCandidates = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Measure complexity and difficulty of meshes, and print their cells."""
    from egad.exchange import check_ending, object_names, write_frame
    from egad.pipeline.cli.terminal_tables import measured
    from egad.pipeline.config.stage_settings import MeasureMeshes, select
    from egad.pipeline.stages import measure as stage
    from egad.report.axes import axis_pair
    from egad.tables.objects import MEASURED

    check_ending(out)
    whole = changed(settings_in(config), "postprocess", max_candidates=max_candidates)
    name = check_name("gripper", gripper or whole.difficulty.gripper, whole.grippers)
    check_name("rule", rule, SCALE_RULES)
    files = object_names(files_in(meshes, units))
    table = stage.run(select(whole, MeasureMeshes, name), files, units, jobs, rule)
    if out is not None:
        write_frame(table, MEASURED, out)
    measured(table, axis_pair(whole.measures), name)
    if note := stage.incomparable(whole, name, rule):
        typer.echo(note)
    complain(_reasons(table), len(table))


@app.command(rich_help_panel=TOOL)
def similarity(
    meshes: Meshes,
    units: Units = None,
    out: TableFile = None,
    bases: Bases = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Compute pairwise similarities of meshes: 1 for equal shapes, 0 for nothing in common."""
    from egad.exchange import check_ending, object_names, write_matrix
    from egad.pipeline.cli.terminal_tables import square
    from egad.pipeline.stages import similarity as stage

    check_ending(out)
    whole = changed(settings_in(config), "similarity", bases=bases)
    files = object_names(files_in(meshes, units))
    matrix, reasons = stage.run(whole.similarity, files, units, jobs)
    if out is not None:
        write_matrix(matrix, out)
    square(matrix)
    complain(reasons, len(files))


@app.command(rich_help_panel=TOOL)
def locate(
    meshes: Meshes,
    among: Among,
    units: Units = None,
    out: PageFile = [Path("locate.html")],  # noqa: B006 (typer copies it)
    max_candidates: MaxCandidates = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Show the positions of meshes in the space of a dataset, and the most similar objects."""
    from egad._util.files import write_text
    from egad.data import archive_path
    from egad.exchange import check_ending, object_names, write_frame
    from egad.pipeline.cli.terminal_tables import located
    from egad.pipeline.config.stage_settings import LocateMeshes, select
    from egad.pipeline.stages import locate as stage
    from egad.report.axes import axis_pair
    from egad.report.locations import page
    from egad.tables.objects import LOCATED

    for path in out:
        check_ending(path, (".html", ".parquet", ".csv"))
    whole = changed(settings_in(config), "postprocess", max_candidates=max_candidates)
    settings = select(whole, LocateMeshes)
    objects = stage.reference(archive_path(among), settings)
    table, shown = stage.run(settings, objects, object_names(files_in(meshes, units)), units, jobs)
    for path in out:
        if path.suffix.lower() == ".html":
            reasons = _reasons(table)
            axes = axis_pair(settings.measures)
            text = page(str(among), objects.objects, shown, reasons, settings.space, axes)
            write_text(path, text)
        else:
            write_frame(table, LOCATED, path)
    located(table, axis_pair(settings.measures))
    complain(_reasons(table), len(table))


def _reasons(table: "pd.DataFrame") -> dict[str, str]:
    """The reasons of the rejected meshes, by name."""
    rejected = table[table["reason"] != ""]
    return dict(zip(rejected["name"], rejected["reason"], strict=True))


def complain(reasons: Mapping[str, str], total: int) -> None:
    """Print the rejected meshes with reasons; raise an error if all were rejected."""
    for name, reason in reasons.items():
        typer.echo(f"{name}: {reason}", err=True)
    if len(reasons) == total:
        raise UserError(f"none of the {total} meshes could be used")
    if reasons:
        typer.echo(f"{len(reasons)} of {total} meshes could not be used", err=True)
