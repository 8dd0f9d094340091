"""Tools for grasps: grasp quality over object size, and a viewer."""

from pathlib import Path
from typing import Annotated

import typer

from egad.errors import UserError, check_name
from egad.pipeline.cli.common import (
    CORES,
    RULE_HELP,
    TOOL,
    Config,
    GripperName,
    Jobs,
    Meshes,
    Units,
    app,
    changed,
    files_in,
    settings_in,
)
from egad.pipeline.cli.measuring import complain

Charts = Annotated[
    list[Path],
    typer.Option("--out", help="file to write: .svg, .parquet or .csv; may be repeated"),
]
Grasps = Annotated[
    int | None, typer.Option(min=1, help="number of grasps; default: as in the configuration")
]


@app.command(name="size-effect", rich_help_panel=TOOL)
def size_effect(
    meshes: Meshes,
    units: Units = None,
    gripper: GripperName = None,
    out: Charts = [],  # noqa: B006 (typer copies it)
    grasps: Grasps = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Compute grasp quality of meshes at several sizes, relative to the gripper opening."""
    from egad._util.files import write_text
    from egad.exchange import check_ending, object_names, write_frame
    from egad.measures import SizeEffectParameters
    from egad.pipeline.cli.terminal_tables import size_curves
    from egad.pipeline.config.stage_settings import select
    from egad.pipeline.stages import size_effect as stage
    from egad.report.grasps import size_chart
    from egad.tables.grasping import SIZE_EFFECT

    for path in out:
        check_ending(path, (".svg", ".parquet", ".csv"))
    whole = changed(settings_in(config), "size_effect", grasps=grasps)
    name = check_name("gripper", gripper or whole.targets.grippers[0], whole.grippers)
    files = object_names(files_in(meshes, units))
    table, reasons = stage.curves(select(whole, SizeEffectParameters, name), files, units, jobs)
    complain(reasons, len(files))
    for path in out:
        if path.suffix.lower() == ".svg":
            write_text(path, size_chart(table))
        else:
            write_frame(table, SIZE_EFFECT, path)
    size_curves(table)


@app.command(rich_help_panel=TOOL)
def view(
    item: Annotated[
        str, typer.Argument(metavar="OBJECT", help="label of an object, or a mesh file")
    ],
    gripper: GripperName = None,
    dataset: Annotated[
        Path, typer.Option("--in", help="folder of the dataset with this label")
    ] = Path("results/egad"),
    units: Units = None,
    rule: Annotated[
        str | None, typer.Option(help=f"{RULE_HELP}; default: as in the configuration")
    ] = None,
    out: Annotated[Path, typer.Option(help="HTML page to write")] = Path("view.html"),
    grasps: Annotated[
        int | None, typer.Option(min=1, help="number of grasps for a mesh file")
    ] = None,
    config: Config = None,
) -> None:
    """Show an object in 3D with its labelled grasps, as an HTML page that works offline."""
    from egad._util.files import write_text
    from egad.exchange import ENDINGS, check_ending
    from egad.io import check_unit_known
    from egad.pipeline.config.stage_settings import ViewMesh, select
    from egad.pipeline.stages import view as stage
    from egad.report.viewer import page

    check_ending(out, (".html",))
    whole = changed(settings_in(config), "grasp_label", grasps=grasps)
    whole = changed(whole, "rescale", rule=rule)
    name = check_name("gripper", gripper or whole.targets.grippers[0], whole.grippers)
    if Path(item).suffix.lower() not in ENDINGS and not Path(item).is_file():
        if rule is not None:
            raise UserError(
                f"--rule is for mesh files; the grasps of {item} were made for one size"
            )
        shown = stage.from_dataset(dataset, name, item, whole.grippers[name].opening)
    else:
        check_unit_known([Path(item)], units)
        shown = stage.from_mesh(Path(item), units, select(whole, ViewMesh, name))
    write_text(out, page(shown, name, whole.grippers[name]))
    free = int(shown.grasps["collision_free"].sum())
    found = shown.note or f"{len(shown.grasps)} grasps of {name}, {free} of them collision-free"
    typer.echo(f"{shown.name}: {found}, at {shown.title}; see {out}")
