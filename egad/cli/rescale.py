"""Meshes scaled to a gripper."""

from typing import Annotated, Literal

import typer

from egad.cli import common


def rescale(
    meshes: common.Meshes,
    out: common.OutFolder,
    gripper: Annotated[str, common.gripper_option()],
    rule: common.Rule = None,
    units: common.Units = None,
    ending: Annotated[
        Literal["obj", "stl"], typer.Option("--format", help="obj is in metres, stl in millimetres")
    ] = "obj",
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Scale meshes to a gripper."""
    from egad.exchange import RescaleMeshes, rescale_files
    from egad.geometry import scale_suffix
    from egad.io import write_sums
    from egad_workflow.provenance import recorded
    from egad_workflow.settings import select

    whole = common.settings_in(config, {"--rule": ("rescale.rule", rule)})
    whole, name = common.gripper_in(whole, gripper)
    settings = select(whole, RescaleMeshes, name)
    meshes = common.files_in(meshes, units)
    common.check_spare(out, meshes)
    suffix = scale_suffix(settings.rescale.rule, settings.gripper.opening)
    with recorded(
        "rescale", settings=settings, inputs=meshes, arguments={"units": units, "format": ending}
    ):
        rejected = rescale_files(settings, meshes, units, out, ending, suffix, jobs)
        write_sums(out)
    if rejected:
        typer.echo(f"{rejected} files were rejected: see {out / 'rejected.parquet'}")
