"""Shared parts of all commands: the application, options, and reading of settings."""

import os
from pathlib import Path
from typing import Annotated, Literal, TypeVar

import typer
import yaml
from pydantic import BaseModel, ValidationError

from egad import __version__
from egad._util.parameters import SCALE_RULES
from egad.errors import UserError
from egad.pipeline.cli.stages import StageGroup
from egad.pipeline.config import Settings

app = typer.Typer(
    cls=StageGroup,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"egad {__version__}")
        raise typer.Exit


@app.callback()
def _program(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="print it")
    ] = False,
) -> None:
    """Evolved objects for robot grasping. Lengths are metres unless stated otherwise."""


TOOL = "Tools"
CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1

Out = Annotated[Path, typer.Option(help="file to write")]
OutFolder = Annotated[Path, typer.Option(help="folder to write")]
Config = Annotated[
    Path | None, typer.Option(help="configuration file, merged into the default settings")
]
Meshes = Annotated[list[Path], typer.Argument(help="mesh files, or folders of mesh files")]
Units = Annotated[
    Literal["m", "cm", "mm", "inch"] | None,
    typer.Option(help="unit of the meshes; needed unless the files state it"),
]
RULE_HELP = f"scaling to the gripper: {', '.join(SCALE_RULES)}"
Rule = Annotated[str, typer.Option(help=RULE_HELP)]
Jobs = Annotated[int, typer.Option(min=1, help="cores to use; results do not depend on it")]
GripperName = Annotated[
    str | None,
    typer.Option("--gripper", help="name of the gripper; default: the first target gripper"),
]
M = TypeVar("M", bound=BaseModel)


def parse(model: type[M], text: str) -> M:
    """The settings that the workflow passes to a stage.

    Raises:
        UserError: They are not settings of the stage.
    """
    try:
        return model.model_validate_json(text)
    except ValidationError as error:
        raise UserError(f"--settings are not valid for this stage: {error}") from error


def settings_in(config: Path | None) -> Settings:
    """The settings of a configuration file, merged into the defaults; without one, the defaults.

    Raises:
        UserError: The file is not YAML, or has settings that are not allowed.
    """
    from egad.pipeline.config.check import check
    from egad.pipeline.config.files import defaults, merged

    if config is None:
        return Settings()
    try:
        values = yaml.safe_load(config.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UserError(f"{config}: not a YAML file: {error}") from error
    return check(merged(defaults(), values or {}))


def files_in(paths: list[Path], units: str | None) -> list[Path]:
    """The given files, and the files in the given folders, without duplicates.

    Raises:
        UserError: No unit is given, and one of the files does not state it.
    """
    from egad.exchange import mesh_files
    from egad.io import check_unit_known

    files: dict[Path, Path] = {}
    for path in paths:
        for file in mesh_files(path) if path.is_dir() else [path]:
            if file.resolve() in files:
                typer.echo(f"{file} is given twice; it is used once", err=True)
            files.setdefault(file.resolve(), file)
    check_unit_known(files.values(), units)
    return list(files.values())


def changed(settings: Settings, section: str, **values: object) -> Settings:
    """The settings with the given values in a section; None keeps a value.

    Raises:
        UserError: A value is not allowed.
    """
    from egad.pipeline.config.check import check

    given = {name: value for name, value in values.items() if value is not None}
    whole = settings.model_dump(mode="json")
    return check({**whole, section: {**whole[section], **given}}) if given else settings
