"""The standard benchmark: a detector clears tables."""

import re
import shlex
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad._util.parameters import SCALE_RULES
from egad.errors import UserError, check_name
from egad.pipeline.cli.common import (
    CORES,
    TOOL,
    Config,
    Jobs,
    Rule,
    Units,
    app,
    changed,
    files_in,
    settings_in,
)

FOLDER = Path("benchmark")

if TYPE_CHECKING:
    from egad.detectors import DetectorConfig
    from egad.named_meshes import NamedMesh
    from egad.pipeline.config import Settings


@app.command(rich_help_panel=TOOL)
def benchmark(
    detector: Annotated[
        str,
        typer.Argument(
            help="FILE.py, FILE.py:NAME or package.module:NAME; or one of the configuration, such "
            "as antipodal-cloud"
        ),
    ],
    weights: Annotated[
        Path | None, typer.Option(help="file of weights that the detector is made with")
    ] = None,
    command: Annotated[
        str | None,
        typer.Option(
            help="command of a detector in its own environment, in quotes; DETECTOR is then its "
            "name in the table"
        ),
    ] = None,
    objects: Annotated[
        str,
        typer.Option(help="evaluation-set, the folder of a dataset, or a folder of mesh files"),
    ] = "evaluation-set",
    units: Units = None,
    gripper: Annotated[str, typer.Option(help="name of the gripper")] = "panda",
    rounds: Annotated[
        int | None, typer.Option(min=1, help="rounds of each kind of scene and noise")
    ] = None,
    keep_going: Annotated[
        bool,
        typer.Option("--keep-going", help="go on with a detector that fails in every attempt"),
    ] = False,
    rule: Rule = "paper",
    films: Annotated[
        Path | None,
        typer.Option(help="folder for films of the first round of each kind of scene"),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="table to write; default: benchmark/DETECTOR.parquet")
    ] = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Let a grasp detector clear tables: success rates and shares of objects cleared."""
    from egad.exchange import check_ending
    from egad.pipeline.cli.terminal_tables import cleared
    from egad.pipeline.config.stage_settings import select
    from egad.pipeline.provenance.record import run_recorded
    from egad.pipeline.stages import benchmark as stage
    from egad.pipeline.stages.clutter import ClearedTables
    from egad.sim import check_engine
    from egad.stats import engine_names

    settings = changed(settings_in(config), "clutter", rounds=rounds, keep_going=keep_going or None)
    check_name("gripper", gripper, settings.grippers)
    check_name("rule", rule, SCALE_RULES)
    check_engine(settings.clutter.engine)
    name, found = _detector(detector, weights, command, settings)
    path = out or FOLDER / f"{name}.parquet"
    for folder in [films, None if out else FOLDER]:
        if folder is not None:
            folder.mkdir(exist_ok=True)
    check_ending(path, (".parquet",))
    targets, files = _objects(objects, units)
    whole = settings.model_copy(update={"detectors": {**settings.detectors, name: found}})
    result = run_recorded(
        stage.run,
        settings=select(whole, ClearedTables, gripper, name),
        objects=Path(objects).name,
        rule=rule,
        targets=targets,
        files=files,
        out=path,
        jobs=jobs,
    )
    cleared({name: result.rates()}, {name: engine_names(result.table)})
    outcomes = result.table["outcome"].value_counts()
    typer.echo(f"outcomes: {', '.join(f'{count} {name}' for name, count in outcomes.items())}")
    typer.echo(f"planning takes {result.planning_time:.2g} s (median); attempts: {path}")
    if films is not None:
        for kind in settings.clutter.scenes:
            result.film(kind, 0, films / f"{name}-{kind}.gif", settings.clutter.noise[0])


def _detector(
    text: str, weights: Path | None, command: str | None, settings: "Settings"
) -> tuple[str, "DetectorConfig"]:
    """The detector of a command line, and what it is called."""
    from egad._util.parameters import from_arguments
    from egad.detectors import DetectorConfig
    from egad.plugins import named

    name = re.sub("[^a-z0-9_-]+", "_", Path(text.partition(":")[0]).stem.lower()).strip("_-")
    if command is not None:
        return name, from_arguments(DetectorConfig, command=shlex.split(command))
    given = None if weights is None else str(weights)
    if known := settings.detectors.get(text):
        return text, known if given is None else known.model_copy(update={"weights": given})
    return name, from_arguments(DetectorConfig, detector=named(text), weights=given)


def _objects(text: str, units: str | None) -> tuple[list["NamedMesh"], list[Path]]:
    """The objects of a command line, and the files that they come from."""
    from egad.exchange import object_names, read_mesh
    from egad.named_meshes import NamedMesh, named_meshes
    from egad.objects import EVALUATION_SET, load
    from egad.tables import parquet
    from egad.tables.evaluation import EVAL49

    folder = Path(text)
    if text == EVALUATION_SET:
        return named_meshes(load(text)), []
    if not folder.is_dir():
        raise UserError(f"--objects {text} is neither {EVALUATION_SET} nor a folder")
    table, chosen = folder / "objects.parquet", folder / "eval49.parquet"
    if chosen.is_file():
        ids = parquet.read(chosen, EVAL49)["id"]
        return named_meshes(load(folder).select(ids)), [table, chosen]
    if table.is_file():
        return named_meshes(load(folder)), [table]
    files = object_names(files_in([folder], units))
    return [
        NamedMesh(name, name, partial(read_mesh, path, units)) for name, path in files.items()
    ], list(files.values())
