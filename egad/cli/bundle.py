"""Objects for simulators, made from mesh files."""

import typer

from egad.cli.common import (
    CORES,
    Config,
    Jobs,
    Meshes,
    OutFolder,
    Units,
    check_spare,
    files_in,
    settings_in,
)


def bundle(
    meshes: Meshes, out: OutFolder, units: Units = None, config: Config = None, jobs: Jobs = CORES
) -> None:
    """Prepare meshes for simulators: convex parts, URDF, MJCF, poses at rest."""
    from egad.exchange import any_objects, write_bundle
    from egad.sim import SimulationBundle
    from egad_workflow.provenance import recorded
    from egad_workflow.settings import select

    settings = select(settings_in(config), SimulationBundle)
    meshes = files_in(meshes, units)
    check_spare(out, meshes, "bundle.parquet")
    with recorded("bundle", settings=settings, inputs=meshes, arguments={"units": units}):
        rejected = write_bundle(settings, any_objects(meshes), units, out, jobs)
    if rejected:
        typer.echo(f"{rejected} objects were rejected: see {out / 'rejected.parquet'}")
