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
    meshes: Meshes,
    out: OutFolder,
    units: Units = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Prepare meshes for simulators: convex parts, URDF, MJCF, poses at rest."""
    from egad.config.stages import SimulationBundle, select
    from egad.provenance.record import recorded
    from egad.workflow.bundle import any_objects, write_bundle

    settings = select(settings_in(config), SimulationBundle)
    meshes = files_in(meshes, units)
    check_spare(out, meshes, "bundle.parquet")
    with recorded("bundle", settings=settings, inputs=meshes, arguments={"units": units}):
        rejected = write_bundle(settings, any_objects(meshes), units, out, jobs)
    if rejected:
        typer.echo(f"{rejected} objects were rejected: see {out / 'rejected.parquet'}")
