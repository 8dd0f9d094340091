"""Exports of objects, labelled grasps and images in the formats of other programs."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from egad.errors import UserError
from egad.pipeline.cli.common import TOOL, Config, Out, app, parse, settings_in
from egad.pipeline.config import Gripper, Settings
from egad.pipeline.exports import (
    ALL,
    EVALUATION_SET,
    OF_OBJECTS,
    Format,
    ObjectSet,
    export_function,
    last_files,
    sources,
)

Dataset = Annotated[
    Path,
    typer.Argument(
        help="folder of a dataset, e.g. results/egad; `released`; or an archive.parquet"
    ),
]
RELEASED = "released"
Parts = Annotated[
    list[Path], typer.Option("--part", help="file of the objects of a shard (format dexnet)")
]


@app.command(rich_help_panel=TOOL)
def export(
    dataset: Dataset,
    gripper: Annotated[str, typer.Option(help="name of the gripper")],
    out: Out,
    ending: Annotated[Format, typer.Option("--format", help="format to write")],
    config: Config = None,
    settings: Annotated[str | None, typer.Option(help="settings of the stage, as JSON")] = None,
    objects: Annotated[
        ObjectSet | None,
        typer.Option(
            help="which objects to write (formats of objects)", show_default="evaluation-set"
        ),
    ] = None,
    part: Parts = [],  # noqa: B006 (typer copies it)
) -> None:
    """Export objects for simulators and browsers, labelled grasps, or rendered images."""
    from egad.exchange import check_opening, grasp_table
    from egad.pipeline.parameters import declared, settings_type
    from egad.pipeline.provenance.record import run_recorded

    if dataset.is_file() or str(dataset) in (RELEASED, EVALUATION_SET):
        given = {"--settings": settings, "--part": part, "--objects": objects}
        _check_applicable(str(dataset), [name for name, value in given.items() if value])
        _export_archive(dataset, gripper, out, ending, config, objects)
        return
    objects = objects or EVALUATION_SET
    run = export_function(ending, objects)
    reads = {name: dataset / file for name, file in sources(ending, gripper, objects).items()}
    if ending in OF_OBJECTS:
        _check_made(dataset / file for file in last_files(ending, gripper, objects))
    for name in reads.keys() & {"grasps", "simulated_grasps"}:
        reads[name] = grasp_table(dataset, gripper)
    parsed: Any = _chosen(settings_type(run), settings, config, gripper)
    check_opening(dataset, gripper, parsed.gripper.opening)
    known = {"settings": parsed, "dataset": dataset, "gripper": gripper, "out": out, **reads}
    known |= {"style": ending, "convex_parts": reads.get("convex_parts")}
    taken = {each.name: known[each.name] for each in declared(run) if each.name in known}
    if ending == "dexnet":
        with _dexnet_parts(taken, part, config) as parts:
            run_recorded(run, **taken, parts=parts)
    else:
        run_recorded(run, **taken)


def _check_applicable(source: str, options: list[str]) -> None:
    """Check the options that are given for objects without a run.

    Raises:
        UserError: Some of them apply to the folder of a run alone.
    """
    wrong = [name for name in options if source != RELEASED or name != "--objects"]
    if wrong:
        raise UserError(f"{', '.join(wrong)}: for the folder of a run, not for {source}")


def _export_archive(
    archive: Path, gripper: str, out: Path, ending: str, config: Path | None, objects: str | None
) -> None:
    """Write objects that no run has scaled or grasped yet, as `egad.export` does.

    Raises:
        UserError: The format needs results of a run.
    """
    from egad.export import FORMATS, export
    from egad.objects import load

    if ending not in FORMATS:
        folder = Path("results/egad")
        files = " ".join(str(folder / file) for file in last_files(ending, gripper))
        shipped = " --configfile config/released.yaml --" if not archive.is_file() else ""
        raise UserError(
            f"{archive} has objects alone, and {ending} needs results of a run; first make them "
            f"with snakemake --cores 2{shipped} {files}, then export {folder}"
        )
    hand = _gripper(settings_in(config), gripper)
    whole = str(archive) != RELEASED or objects == ALL
    export(
        load(str(archive) if whole else EVALUATION_SET), ending, hand if config else gripper, out
    )


def _check_made(files: Iterable[Path]) -> None:
    """Check that files of a run exist.

    Raises:
        UserError: One does not.
    """
    for file in files:
        if not file.exists():
            raise UserError(f"{file} is missing; make it first: snakemake --cores 2 {file}")


@contextmanager
def _dexnet_parts(
    given: dict[str, Any], parts: list[Path], config: Path | None
) -> Iterator[list[Path]]:
    """The given parts of a Dex-Net database; if there are none, a new one."""
    from egad.pipeline.exports.dexnet import check
    from egad.pipeline.stages import dexnet_objects

    dataset, gripper, out = given["dataset"], given["gripper"], given["out"]
    if out.is_dir():
        raise UserError(f"--out {out} is a folder; name a file")
    if out.suffix != ".hdf5":
        raise UserError(
            f"--out {out}: the name must end in .hdf5, otherwise Dex-Net does not open it"
        )
    if parts:
        yield parts
        return
    check(dataset, gripper, given["grasps"])
    settings = _chosen(dexnet_objects.DexNetObjects, None, config)
    whole = out.with_name(f".{out.name}.objects")
    try:
        meshes = dataset / "rescaled" / gripper
        dexnet_objects.run(settings, dataset / "objects.parquet", meshes, (0, 1), whole)
        yield [whole]
    finally:
        whole.unlink(missing_ok=True)


def _chosen(
    stage: Any,  # noqa: ANN401 (the class of the settings of a format)
    text: str | None,
    config: Path | None,
    gripper: str | None = None,
) -> Any:  # noqa: ANN401 (of that class)
    """The settings of a stage, from the given text or from a configuration."""
    from egad.pipeline.config.stage_settings import select

    if text is not None:
        return parse(stage, text)
    whole = settings_in(config)
    if gripper is not None:
        _gripper(whole, gripper)
    return select(whole, stage, gripper)


def _gripper(settings: Settings, name: str) -> Gripper:
    """A gripper of a configuration.

    Raises:
        UserError: It has none of this name.
    """
    if name not in settings.grippers:
        raise UserError(
            f"gripper {name!r} is not in the configuration (--config); "
            f"known: {', '.join(settings.grippers)}"
        )
    return settings.grippers[name]
