"""Options that several commands share, and how they are read."""

import re
import shlex
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from egad._util.files import check_writable
from egad._util.parameters import ScaleRule
from egad.cli.cpus import available_cpus
from egad.errors import UserError, check_name
from egad.grippers import GRIPPERS, PACKAGED, Gripper, gripper
from egad_workflow.settings import Settings

if TYPE_CHECKING:
    import pandas as pd

    from egad.objects import NamedMesh

CORES = available_cpus()
RUN = Path("results/egad")  # of the default configuration
FIRST_TARGET = "the first of targets.grippers"


def out_option(help: str) -> Any:  # noqa: A002, ANN401 (as in typer)
    """The option for what a command writes."""
    return typer.Option("--out", "-o", help=help, callback=_check_writable)


def _check_writable(out: Path | list[Path] | None) -> Path | list[Path] | None:
    """Check before the work that its results can be written."""
    for path in out if isinstance(out, list) else [out]:
        if path is not None:
            check_writable(path)
    return out


def grippers_like(incomplete: str) -> list[str]:
    """The grippers that a shell offers while `--gripper` is being typed."""
    return [name for name in (*GRIPPERS, *PACKAGED) if name.startswith(incomplete)]


def gripper_option(default: str = "", opening: bool = True) -> Any:  # noqa: ANN401 (as in typer)
    """The option for the gripper; the default is only told. `opening`: whether one is accepted."""
    words = ["gripper of the configuration"]
    words += ["or an opening in metres, such as 0.08"] if opening else []
    told = ", ".join(words) + (f"; default: {default}" if default else "")
    return typer.Option("--gripper", help=told, autocompletion=grippers_like)


Config = Annotated[
    Path | None, typer.Option("--config", help="configuration file, merged into the defaults")
]
Meshes = Annotated[list[Path], typer.Argument(help="mesh files, or folders of mesh files")]
Units = Annotated[
    Literal["m", "cm", "mm", "inch"] | None,
    typer.Option("--units", help="unit of the meshes; needed unless the files state it"),
]
Rule = Annotated[
    ScaleRule | None,
    typer.Option(
        "--rule", help="scaling to the gripper; default: rescale.rule, paper unless configured"
    ),
]
Jobs = Annotated[
    int, typer.Option("--jobs", min=1, help="cores to use; results do not depend on it")
]
OutFolder = Annotated[Path, out_option("folder to write")]
DetectorName = Annotated[
    str,
    typer.Argument(
        metavar="DETECTOR",
        help="FILE.py, FILE.py:NAME or package.module:NAME; a detector of the configuration, such "
        "as antipodal-cloud; or known grasps: grasps:FILE, or grasps:FOLDER with a file per object",
    ),
]
Weights = Annotated[Path | None, typer.Option("--weights", help="file of weights for the detector")]
Command = Annotated[
    str | None,
    typer.Option(
        "--command",
        help="command of a detector in its own environment, in quotes; DETECTOR is then its name",
    ),
]
Objects = Annotated[
    str,
    typer.Option(
        "--objects",
        help="evaluation-set, released, the folder of a dataset, or a folder of mesh files",
    ),
]
KeepGoing = Annotated[
    bool, typer.Option("--keep-going", help="continue even if the detector fails in every attempt")
]
TableFile = Annotated[Path | None, out_option("table to write: .parquet or .csv")]
Dataset = Annotated[Path, typer.Argument(help="folder of a dataset, e.g. results/egad")]
ArchiveFile = Annotated[Path, typer.Argument(help="archive.parquet, or `released`")]
DatasetIn = Annotated[Path, typer.Option("--in", help="folder of the dataset")]
MaxCandidates = Annotated[
    int | None,
    typer.Option(
        min=1,
        help="maximum number of candidate grasps for the graspability; default: as in the "
        "configuration",
    ),
]


def settings_in(
    config: Path | None, options: Mapping[str, tuple[str, object]] | None = None
) -> Settings:
    """Settings of a YAML file over the defaults; `options` have a key and a value or None."""
    from egad_workflow.check import check
    from egad_workflow.config_files import defaults, merged, read_values

    values = {} if config is None else merged(defaults(), read_values(config))
    given = {option: pair for option, pair in (options or {}).items() if pair[1] is not None}
    for key, value in given.values():
        section, _, name = key.partition(".")
        values = merged(values, {section: {name: value} if name else value})
    try:
        return check(values) if values else Settings()
    except UserError as error:
        text = str(error)
        for option, (key, _) in given.items():
            text = re.sub(rf"^(?={re.escape(key)}\b)", f"{option}: ", text, flags=re.MULTILINE)
        raise UserError(text) from error


def gripper_in(settings: Settings, given: str) -> tuple[Settings, str]:
    """Settings with the gripper of `--gripper`, a name or an opening in metres; and its name."""
    settings = with_packaged(settings, given)
    opening = None if given in settings.grippers else _number(given)
    if opening is None:
        names = [*settings.grippers, *(set(PACKAGED) - set(settings.grippers))]
        return settings, check_name("--gripper", given, names, ", nor is it an opening in metres")
    try:
        added = Gripper(opening=opening)
    except UserError as error:
        raise UserError(f"--gripper {given}: {error}") from error
    name = f"{opening:g} m"
    return settings.model_copy(update={"grippers": {**settings.grippers, name: added}}), name


def detector_in(
    settings: Settings, text: str, weights: Path | None, command: str | None
) -> tuple[Settings, str]:
    """Settings with the detector of a command line (see `DetectorName`), and its name there."""
    from egad._util.parameters import from_arguments
    from egad.detectors import KNOWN_GRASPS, DetectorConfig
    from egad.plugins import named

    is_known = text.startswith(KNOWN_GRASPS)
    stem = Path(text.removeprefix(KNOWN_GRASPS) if is_known else text.partition(":")[0]).stem
    name = re.sub("[^a-z0-9_-]+", "_", stem.lower()).strip("_-")
    given = None if weights is None else str(weights)
    if command is not None:
        found = from_arguments(DetectorConfig, command=shlex.split(command), weights=given)
    elif known := settings.detectors.get(text):
        changed = {} if given is None else {"weights": given}
        name, found = text, from_arguments(DetectorConfig, **known.model_dump() | changed)
    else:
        own = text if is_known else named(text)
        found = from_arguments(DetectorConfig, detector=own, weights=given)
    return settings.model_copy(update={"detectors": {**settings.detectors, name: found}}), name


def settings_to_try(
    config: Path | None,
    options: Mapping[str, tuple[str, object]],
    gripper: str,
    detector: str,
    weights: Path | None,
    command: str | None,
) -> tuple[Settings, str, str]:
    """Settings with the gripper and detector that a command tries, and the names of both."""
    settings, hand = gripper_in(settings_in(config, options), gripper)
    settings, name = detector_in(settings, detector, weights, command)
    return settings, hand, name


def with_packaged(settings: Settings, name: str | None) -> Settings:
    """Settings with a gripper from another package, if it is asked for by its name."""
    if name not in PACKAGED or name in settings.grippers:
        return settings
    return settings.model_copy(update={"grippers": {**settings.grippers, name: gripper(name)}})


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def named_gripper(settings: Settings, given: str | None) -> tuple[Settings, str]:
    """Settings with the gripper of `--gripper`, for results of a run, which contain its name."""
    settings, name = with_packaged(settings, given), given or settings.targets.grippers[0]
    check_name("--gripper", name, settings.grippers, " in the configuration (--config)")
    return settings, name


def files_in(paths: Sequence[Path], units: str | None) -> list[Path]:
    """The given files, and those in the given folders, once each; UserError if one lacks a unit."""
    from egad.io import check_unit_known, mesh_files

    files: dict[Path, Path] = {}
    for path in paths:
        for file in mesh_files(path) if path.is_dir() else [path]:
            if file.resolve() in files:
                typer.echo(f"{file} is given twice; it is used once", err=True)
            files.setdefault(file.resolve(), file)
    check_unit_known(files.values(), units)
    return list(files.values())


def objects_in(text: str, units: str | None) -> tuple[list["NamedMesh"], list[Path]]:
    """The objects of `--objects`, and their files; of a dataset, those of its evaluation set."""
    from egad.io import object_names, read_mesh
    from egad.objects import EVALUATION_SET, RELEASED, NamedMesh, load, named_meshes
    from egad.tables import parquet
    from egad.tables.evaluation import EVAL49

    folder = Path(text)
    if text in (EVALUATION_SET, RELEASED):
        return named_meshes(load(text)), []
    if not folder.is_dir():
        raise UserError(f"--objects {text} is neither {EVALUATION_SET}, {RELEASED} nor a folder")
    table, chosen = folder / "objects.parquet", folder / "eval49.parquet"
    if chosen.is_file():
        rows = parquet.read(chosen, EVAL49)
        labels = dict(zip(rows["id"], rows["label"], strict=True))
        targets = named_meshes(load(folder).select(rows["id"]))
        return [each._replace(label=labels[each.id]) for each in targets], [table, chosen]
    if table.is_file():
        return named_meshes(load(folder)), [table]
    files = object_names(files_in([folder], units))
    return [
        NamedMesh(name, name, partial(read_mesh, path, units)) for name, path in files.items()
    ], list(files.values())


def are_meshes(files: Sequence[Path]) -> bool:
    """Whether the files of `objects_in` are meshes, which keep their size, not of a dataset."""
    return bool(files) and files[0].suffix != ".parquet"


def check_spare(folder: Path, files: Sequence[Path] = (), table: str = "scales.parquet") -> None:
    """UserError if the folder of `--out` has files that this command did not write (`table`)."""
    foreign = folder.exists() and any(folder.iterdir()) and not (folder / table).exists()
    inside = any(folder.resolve() in file.resolve().parents for file in files)
    if foreign or inside:
        raise UserError(f"--out {folder} has other files, which would be lost; give another folder")


def reasons_in(table: "pd.DataFrame") -> dict[str, str]:
    """The reasons of the rejected meshes, by name: from the columns name and reason."""
    rejected = table[table["reason"] != ""]
    return dict(zip(rejected["name"], rejected["reason"], strict=True))


def complain(reasons: Mapping[str, str], total: int) -> None:
    """Print the rejected meshes with reasons; raise an error if all were rejected."""
    for name, reason in reasons.items():
        typer.echo(f"{name}: {reason}", err=True)
    if len(reasons) == total:
        raise UserError(f"none of the {total} meshes could be used")
    if reasons:
        typer.echo(f"{len(reasons)} of {total} meshes could not be used", err=True)
