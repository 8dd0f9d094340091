"""Where files come from, and whether they are still what was made."""

from pathlib import Path
from typing import Annotated

import typer

from egad.pipeline.cli.common import TOOL, app


@app.command(rich_help_panel=TOOL)
def provenance(
    file: Annotated[Path, typer.Argument(help="file or folder that the pipeline made")],
) -> None:
    """Print what a file was made from and by, as a tree back to the seed."""
    from egad.errors import UserError
    from egad.pipeline.provenance.tree import tree

    if not file.exists():
        raise UserError(f"{file}: there is no such file")
    for line in tree(file):
        typer.echo(line)


@app.command(rich_help_panel=TOOL)
def verify(
    folder: Annotated[Path, typer.Argument(help="folder of a dataset, e.g. results/egad")],
) -> None:
    """Say whether anything in a folder was altered since it was made; the status is 1 if so."""
    from egad.pipeline.provenance.verify import verify as look

    verdict = look(folder)
    for path, problem in verdict.problems.items():
        typer.echo(f"{path}: {problem}")
    if verdict.unknown:
        names = ", ".join(str(path) for path in verdict.unknown[:5])
        more = ", ..." if len(verdict.unknown) > 5 else ""
        typer.echo(f"nothing is noted of {len(verdict.unknown)} files: {names}{more}")
    if verdict.gone:
        typer.echo(f"{verdict.gone} inputs are not there and could not be compared")
    typer.echo(f"{verdict.checked} files compared, {len(verdict.problems)} not as they were made")
    if verdict.problems:
        raise typer.Exit(1)
