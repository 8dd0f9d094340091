"""What all commands share: the application, options, and how settings are read."""

import os
from pathlib import Path
from typing import Annotated, Literal, TypeVar

import typer
import yaml
from pydantic import BaseModel, ValidationError

from egad.errors import UserError
from egad.pipeline.cli.stages import StageGroup
from egad.pipeline.config import Settings

app = typer.Typer(
    cls=StageGroup,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Evolved objects for robot grasping. Commands take metres unless they say otherwise.",
)
TOOL = "Tools"
CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1

Out = Annotated[Path, typer.Option(help="file to write")]
OutFolder = Annotated[Path, typer.Option(help="folder to write")]
Config = Annotated[Path | None, typer.Option(help="configuration file; else the defaults")]
Meshes = Annotated[list[Path], typer.Argument(help="mesh files or folders of them")]
Units = Annotated[Literal["m", "cm", "mm", "inch"], typer.Option(help="unit of the meshes")]
Jobs = Annotated[int, typer.Option(min=1, help="cores to use; no result depends on it")]
GripperName = Annotated[
    str | None,
    typer.Option("--gripper", help="name of the gripper; else the first target"),
]
M = TypeVar("M", bound=BaseModel)


def parse(model: type[M], text: str) -> M:
    """The settings that the workflow hands to a stage.

    Raises:
        UserError: They are not what the stage reads.
    """
    try:
        return model.model_validate_json(text)
    except ValidationError as error:
        raise UserError(f"--settings is not what this stage reads: {error}") from error


def settings_in(config: Path | None) -> Settings:
    """The settings of a configuration file; the defaults without one.

    Raises:
        UserError: The file is not YAML, or has settings that are not allowed.
    """
    from egad.pipeline.config.check import check

    if config is None:
        return Settings()
    try:
        values = yaml.safe_load(config.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UserError(f"{config}: not a YAML file: {error}") from error
    return check(values or {})


def files_in(paths: list[Path]) -> list[Path]:
    """The files that are named, and those in the folders that are named, each once."""
    from egad.exchange.folders import mesh_files

    files: dict[Path, Path] = {}
    for path in paths:
        for file in mesh_files(path) if path.is_dir() else [path]:
            if file.resolve() in files:
                typer.echo(f"{file} is named twice and taken once", err=True)
            files.setdefault(file.resolve(), file)
    return list(files.values())


def changed(settings: Settings, section: str, **values: object) -> Settings:
    """The settings with other values in a section, but for those that are None.

    Raises:
        UserError: A value is not allowed.
    """
    from egad.pipeline.config.check import check

    given = {name: value for name, value in values.items() if value is not None}
    whole = settings.model_dump(mode="json")
    return check({**whole, section: {**whole[section], **given}}) if given else settings
