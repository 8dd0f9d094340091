"""The check of configuration files."""

from pathlib import Path
from typing import Annotated

import typer

from egad.cli.common import settings_in


def check_config(
    files: Annotated[list[Path], typer.Argument(help="configuration files")],
) -> None:
    """Check configuration files and list all problems."""
    for file in files:
        settings_in(file)
        typer.echo(f"{file}: fine")
