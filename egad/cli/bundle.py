"""Objects for simulators, made from mesh files."""

import typer

from egad.cli import common


def bundle(
    meshes: common.Meshes,
    out: common.OutFolder,
    units: common.Units = None,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Prepare meshes for simulators: convex parts, URDF, MJCF, poses at rest."""
    from egad.exchange import any_objects, write_bundle
    from egad.sim import SimulationBundle
    from egad_workflow.provenance import recorded
    from egad_workflow.settings import select

    settings = select(common.settings_in(config), SimulationBundle)
    meshes = common.files_in(meshes, units)
    common.check_spare(out, meshes, "bundle.parquet")
    with recorded("bundle", settings=settings, inputs=meshes, arguments={"units": units}):
        rejected = write_bundle(settings, any_objects(meshes), units, out, jobs)
    if rejected:
        typer.echo(f"{rejected} objects were rejected: see {out / 'rejected.parquet'}")
