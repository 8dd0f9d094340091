"""The commands, in the four groups that `egad --help` shows."""

from collections.abc import Callable, Sequence
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from egad import __version__
from egad.cli.benchmark import benchmark
from egad.cli.bundle import bundle
from egad.cli.design import design
from egad.cli.export import export
from egad.cli.export_meshes import export_meshes
from egad.cli.failures import failures
from egad.cli.genome import genome
from egad.cli.grasps import grasps
from egad.cli.gripper import gripper
from egad.cli.hands import hands
from egad.cli.locate import locate
from egad.cli.log_sheet import log_sheet
from egad.cli.measure import measure
from egad.cli.provenance import check_config, provenance, verify
from egad.cli.rescale import rescale
from egad.cli.similarity import similarity
from egad.cli.size_effect import size_effect
from egad.cli.train import train
from egad.cli.trials import trials
from egad.cli.view import view

GROUPS: dict[str, Sequence[Callable[..., None] | typer.Typer]] = {
    "Objects": (measure, similarity, locate, genome, export_meshes, bundle),
    "Grasps and grippers": (rescale, view, size_effect, grasps, gripper, hands, design),
    "Detectors": (benchmark, failures, train, trials, log_sheet),
    "Files and runs": (export, check_config, provenance, verify),
}


class _Group(TyperGroup):
    """The commands; none reads the terminal, so a file that ends early is no reason to say so."""

    def invoke(self, ctx: Any) -> Any:  # noqa: ANN401 (of typer)
        try:
            return super().invoke(ctx)
        except EOFError as error:
            raise RuntimeError("a file ends too early") from error


app = typer.Typer(cls=_Group, no_args_is_help=True, pretty_exceptions_enable=False)


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"egad {__version__}")
        raise typer.Exit


@app.callback()
def _program(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="print the version"),
    ] = False,
) -> None:
    """Evolved objects for robot grasping. Lengths are metres unless stated otherwise."""


for group, commands in GROUPS.items():
    for command in commands:
        if isinstance(command, typer.Typer):
            app.add_typer(command, rich_help_panel=group)
        else:
            app.command(rich_help_panel=group)(command)
