"""Grasp quality as a function of the size of objects."""

from pathlib import Path
from typing import Annotated

import typer

from egad.cli import common


def size_effect(
    meshes: common.Meshes,
    units: common.Units = None,
    gripper: Annotated[str | None, common.gripper_option(common.FIRST_TARGET)] = None,
    out: Annotated[
        list[Path], common.out_option("file to write: .svg, .parquet or .csv; may be repeated")
    ] = [],  # noqa: B006 (typer copies it)
    grasps: Annotated[
        int | None, typer.Option(min=1, help="number of grasps; default: as in the configuration")
    ] = None,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Compute grasp quality of meshes at several sizes, relative to the gripper opening."""
    from egad._util.files import write_text
    from egad.cli.table_files import write_frame
    from egad.cli.terminal_tables import size_curves
    from egad.io import check_ending, object_names
    from egad.measures import SizeEffectParameters
    from egad.measures.size_effect import curves
    from egad.report.grasps import size_chart
    from egad.tables.grasping import SIZE_EFFECT
    from egad_workflow.settings import select

    for path in out:
        check_ending(path, (".svg", ".parquet", ".csv"))
    whole = common.settings_in(config, {"--grasps": ("size_effect.grasps", grasps)})
    whole, name = common.gripper_in(whole, gripper or whole.targets.grippers[0])
    files = object_names(common.files_in(meshes, units))
    table, reasons = curves(select(whole, SizeEffectParameters, name), files, units, jobs)
    common.complain(reasons, len(files))
    for path in out:
        if path.suffix.lower() == ".svg":
            write_text(path, size_chart(table))
        else:
            write_frame(table, SIZE_EFFECT, path)
    size_curves(table)
