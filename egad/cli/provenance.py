"""The check of configuration files, provenance of files, and verification of checksums."""

from pathlib import Path
from typing import Annotated

import typer

from egad.cli import common
from egad.errors import UserError


def provenance(
    file: Annotated[Path, typer.Argument(help="file or folder made by the pipeline")],
) -> None:
    """Print the provenance of a file, as a tree back to the seed."""
    from egad_workflow.provenance_tree import tree

    if not file.exists():
        raise UserError(f"{file}: no such file")
    for line in tree(file):
        typer.echo(line)


def verify(
    folder: Annotated[Path, typer.Argument(help="folder of a dataset, e.g. results/egad")],
) -> None:
    """Check whether files in a folder were altered; the exit status is 1 if so."""
    from egad_workflow.verify import verify as look

    verdict = look(folder)
    for path, problem in verdict.problems.items():
        typer.echo(f"{path}: {problem}")
    if verdict.unknown:
        names = ", ".join(str(path) for path in verdict.unknown[:5])
        more = ", ..." if len(verdict.unknown) > 5 else ""
        typer.echo(f"no provenance of {len(verdict.unknown)} files: {names}{more}")
    if verdict.gone:
        typer.echo(f"{verdict.gone} inputs are missing and could not be checked")
    typer.echo(f"{verdict.checked} files checked, {len(verdict.problems)} altered or missing")
    if verdict.problems:
        raise typer.Exit(1)


def check_config(files: Annotated[list[Path], typer.Argument(help="configuration files")]) -> None:
    """Check configuration files and list all problems, also of the files that they name."""
    from egad_workflow.input_files import check_input_files

    for file in files:
        check_input_files(common.settings_in(file))
        typer.echo(f"{file}: fine")
