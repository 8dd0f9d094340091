"""Failures of a detector: objects that can be grasped but that it does not grasp."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from egad._util.files import check_writable
from egad.cli import common
from egad.errors import UserError

if TYPE_CHECKING:
    from egad.bench.failures import FailureAtlas
    from egad.objects import Dataset

FILMS = 20
PAGE = "index.html"
TABLES = {
    "failures": "the failures; egad.load reads them as a dataset",
    "examined": "all objects that the search considered",
    "attempts": "the attempts",
}


def failures(
    detector: common.DetectorName,
    weights: common.Weights = None,
    command: common.Command = None,
    gripper: Annotated[str, common.gripper_option()] = "panda",
    objects: Annotated[
        str,
        typer.Option(help="released, the folder of a dataset of evolved objects, or an archive"),
    ] = "released",
    attempts: Annotated[
        int | None,
        typer.Option(
            min=1, help="total number of simulated grasps, 0.15 s each; default: failures.attempts"
        ),
    ] = None,
    strategy: Annotated[
        Literal["evolution", "screening", "mutation", "random"] | None,
        typer.Option(help="where objects come from; default: failures.strategy"),
    ] = None,
    approach: Annotated[
        Literal["above", "any"] | None,
        typer.Option(
            help="grasps straight from above or in any direction; default: failures.approach, or "
            "what the detector asks for"
        ),
    ] = None,
    depth_noise: Annotated[
        float | None,
        typer.Option(help="noise of depth images, pixels; default: failures.depth_noise"),
    ] = None,
    least_difference: Annotated[
        float | None,
        typer.Option(
            help="minimum difference between the success rates of the reference and the detector "
            "at a failure; default: failures.least_difference"
        ),
    ] = None,
    engines: Annotated[
        str | None,
        typer.Option(
            help="physics engines, separated by commas; a failure must be one in all of them; "
            "default: failures.engines"
        ),
    ] = None,
    rule: common.Rule = None,
    films: Annotated[
        int, typer.Option(min=0, help="number of the worst failures to show films of on the page")
    ] = FILMS,
    out: Annotated[
        Path | None,
        common.out_option(
            "folder to write; an interrupted search resumes from it; default: failures/DETECTOR"
        ),
    ] = None,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Search for objects at which a grasp detector fails although they can be grasped."""
    from egad.bench.failures import DetectorFailures, check_searchable, search_failures
    from egad.detectors import keep_failure
    from egad.report.failure_atlas import write_page
    from egad_workflow.provenance import recorded
    from egad_workflow.settings import select

    options = {
        "--attempts": ("failures.attempts", attempts),
        "--strategy": ("failures.strategy", strategy),
        "--approach": ("failures.approach", approach),
        "--depth-noise": ("failures.depth_noise", depth_noise),
        "--least-difference": ("failures.least_difference", least_difference),
        "--engines": ("failures.engines", engines.split(",") if engines else None),
        "--rule": ("rescale.rule", rule),
    }
    settings, gripper, name = common.settings_to_try(
        config, options, gripper, detector, weights, command
    )
    check_searchable(settings.detectors[name], settings.grippers[gripper])
    chosen, files = _objects(objects)
    settings = settings.model_copy(update={"shape": chosen.shape})
    found = select(settings, DetectorFailures, gripper, name)
    folder = out or Path("failures") / name
    check_writable(folder)
    arguments = {"objects": Path(objects).name}
    with (
        recorded("failures", settings=found, inputs=files, arguments=arguments),
        keep_failure(folder / "failures.parquet"),
    ):
        atlas = search_failures(chosen.archive, found.detector, found, jobs, folder)
    if len(atlas):
        write_page(atlas, folder / PAGE, films, objects=chosen, jobs=jobs)
    _tell(atlas, name, folder)


def _objects(text: str) -> tuple["Dataset", list[Path]]:
    """The objects named on a command line, and the files that they come from."""
    from egad.objects import EVALUATION_SET, RELEASED, load

    try:
        found = load(text)
        found.archive  # noqa: B018 (there may be none)
    except UserError as error:
        raise UserError(f"--objects {text}: {error}") from error
    path = Path(text)
    if text in (RELEASED, EVALUATION_SET):
        return found, []
    tables = [path / name for name in ("objects.parquet", "archive.parquet")]
    return found, tables if path.is_dir() else [path]


def _tell(atlas: "FailureAtlas", name: str, folder: Path) -> None:
    from egad.bench.failures import ObjectVerdict

    counts = atlas.examined["verdict"].value_counts()
    typer.echo(f"failures of {name}: {len(atlas)}, in {atlas.cells} cells")
    tried = int((atlas.examined["attempts"] > 0).sum())
    typer.echo(f"attempts: {int(atlas.examined['attempts'].sum())}, at {tried} objects")
    typer.echo(f"objects: {len(atlas.examined)}")
    for verdict in ObjectVerdict:
        if verdict in counts:
            name = verdict.replace("_", " ")
            typer.echo(f"{counts[verdict]:6} {name}: {verdict.meaning}")
    for table, text in TABLES.items():
        typer.echo(f"{folder / table}.parquet: {text}")
    if len(atlas):
        typer.echo(f"{folder / PAGE}: the failures as a page, with films of the worst ones")
